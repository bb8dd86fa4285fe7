# SPDX-License-Identifier: Apache-2.0
"""What a tool takes, described for models: read from the signature of the function that it is.

Rule: a bound, a default and a description are written once, where the function is.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, signature
from typing import Annotated, Any, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, create_model

__all__ = ("Age", "Metres", "Name", "Text", "Timeout", "TypeName", "arguments_of")

LONGEST = 255
Text = Annotated[str, Field(max_length=LONGEST)]
Name = Annotated[Text, Field(min_length=1)]
TypeName = Annotated[Text, Field(description="Its type, 'std_msgs/msg/String'; empty: found out from the robot.")]
WAIT = "How long to wait for it, in seconds; 0 to 60."
Timeout = Annotated[float, Field(ge=0, le=60, allow_inf_nan=False, description=WAIT)]
Age = Annotated[float | None, Field(ge=0, allow_inf_nan=False, description="The oldest that will do, in seconds.")]
Metres = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]


def arguments_of(act: Callable[..., Any]) -> type[BaseModel]:
    """What a function takes, as a model of pydantic's that takes nothing else."""
    types = get_type_hints(act, include_extras=True)
    fields: dict[str, Any] = {
        name: (types[name], ... if each.default is Parameter.empty else each.default)
        for name, each in signature(act).parameters.items()
    }
    return create_model(act.__name__, __config__=ConfigDict(extra="forbid"), **fields)
