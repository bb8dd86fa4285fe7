# SPDX-License-Identifier: Apache-2.0
"""How a robot is reached: the `Connector` protocol, its contract, a connector inside the process, and one a middleware.

Imports the modules of the root only.
"""

__all__ = ()
