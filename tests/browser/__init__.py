# SPDX-License-Identifier: Apache-2.0
"""A package, so that its browser is closed behind its last test (the scope `package`)."""
