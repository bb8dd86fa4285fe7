# SPDX-License-Identifier: Apache-2.0
"""`rai-missions schema`."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from rai_missions.cli.command import Argument, command

__all__ = ("schema",)


@command(only_reads=True)
def schema(kind: Annotated[Literal["mission", "robot", "map", "campaign"], Argument()] = "mission") -> int:
    """Print the JSON Schema of missions, robot profiles, migration maps or campaigns.

    An editor that knows the schema completes names and marks faults while you write.

    Args:
        kind: The kind of file.

    Exit status:
        0 it was printed, 2 the input is at fault

    Example:
        rai-missions schema robot > robot.schema.json
    """
    import json

    print(json.dumps(_schema(kind), indent=2, ensure_ascii=False))
    return 0


def _schema(kind: str) -> Any:
    if kind == "robot":
        from rai_missions.profile.schema import robot_schema

        return robot_schema()
    if kind == "campaign":
        from rai_missions.campaign.file import campaign_schema

        return campaign_schema()
    if kind == "map":
        from rai_missions.replay.migrate import map_schema

        return map_schema()
    from rai_missions.mission.schema import mission_schema

    return mission_schema()
