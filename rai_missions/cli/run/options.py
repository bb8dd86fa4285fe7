# SPDX-License-Identifier: Apache-2.0
"""What `rai-missions run` takes: its arguments and options, with their help."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from rai_missions.cli.command import PAGE_PORT, Argument, GuardsFile, JournalFile, RobotFile, read_speed

__all__ = ("RunOptions",)

MISSION = Argument("MISSION", files=("*.json", "*.py"), is_positional=True)


class RunOptions(NamedTuple):
    """What a run takes.

    Args:
        mission: A .json file, or a .py file with a mission or a function mission().
        resume: Resume a run that was cut short. Its mission and profile are in its journal.
        migrate: A .json file that maps the states and keys of the run of --resume to those of MISSION, which has
            changed (see: rai-missions schema map). What it does not name must be unchanged.
        robot: The robot profile, which connects the mission's names to a robot; or a robot in Python, a .py file with
            a PythonRobot, which is executed.
        set: Set an argument of the mission; may be repeated.
        model: The model that answers as 'agent': openai:NAME, anthropic:NAME, ollama:NAME, or local:FILE.gguf on this
            machine; local alone is a toy of 135 M parameters that answers by chance.
        model_memory: The memory in GiB that the model's process may use, with what it starts.
        no_operator: Ask no operator, on the terminal or elsewhere.
        guards: A Python file with the predicates of 'named' guards. It is executed.
        no_python: Refuse a mission, a robot and guards in Python.
        journal: The file in which the run is recorded. Without it: journals/NAME-TIME-PROCESS.journal.
        record: Record messages, pictures, steps and the journal as MCAP, for Foxglove and replay (extra 'record').
        picture: Draw the path taken when the run ends: .svg, .png, .dot, .mmd, .md.
        speed: The speed of simulated time: 1 is the wall clock's, 5 is five times that, 0.5 is half, max is as fast as
            possible. Without this, it is max for a simulated world, and a robot in Python has the time of the wall.
            While a model or a person is asked it is 1 at most.
        seed: The simulated world's seed, instead of the profile's.
        json: Print one object at the end, and nothing else on stdout.
        verbose: Print also the steps that changed nothing.
        node: Serve the run on the robot's graph: lifecycle, commands, status, diagnostics. Without NAME, the node has
            the mission's name.
        managed: Be a node that runs the mission each time it is activated, until it is shut down.
        talk: Talk with the robot: on this terminal, on the page of --watch, and on topics where the profile has "hri".
            The model of --model takes part. Simulated time is the wall's unless --speed is given.
        voice: With --talk: also by the microphone and the speaker of this machine (extra 'voice'), in flite's voice or
            that of NAME: espeak, piper, kokoro, or one of another package; with options as flite:speaker=rms.
        recogniser: With --talk: whisper, or a recogniser of another package; with options as whisper:weights=base,
            whisper:folder=MODEL.
        wake_word: With --voice: okay_nabu, hey_jarvis, hey_mycroft or alexa; other sentences are dropped, except stop.
        watch: Show the run on a web page, where the operator may act. Without PORT: 8765; 0 is any free port (extra
            'watch').
        host: The address on which the page listens, which needs TLS; without it, 127.0.0.1.
        tls_cert: The page's certificate, PEM.
        tls_key: The certificate's private key, PEM.
        ros_args: Arguments for ROS; ros2 launch appends them.
    """

    mission: Annotated[str | None, MISSION] = None
    resume: JournalFile | None = None
    migrate: Annotated[str | None, Argument("MAP", files=("*.json",))] = None
    robot: RobotFile | None = None
    set: tuple[Annotated[str, Argument("KEY=VALUE")], ...] = ()
    model: Annotated[str | None, Argument("PROVIDER:NAME")] = None
    model_memory: Annotated[float, Argument("GIB")] = 2.0
    no_operator: bool = False
    guards: GuardsFile | None = None
    no_python: bool = False
    journal: Annotated[str | None, Argument("FILE", files=("*", "*.journal"))] = None
    record: Annotated[str | None, Argument("FILE.mcap", files=("*.mcap",))] = None
    picture: Annotated[str | None, Argument("FILE", files=("*",))] = None
    speed: Annotated[float | None, Argument("N|max", parse=read_speed)] = None
    seed: Annotated[int | None, Argument("N")] = None
    json: bool = False
    verbose: bool = False
    node: Annotated[str | None, Argument("NAME", bare="")] = None
    managed: bool = False
    talk: bool = False
    voice: Annotated[str | None, Argument("NAME", bare="flite")] = None
    recogniser: Annotated[str, Argument("NAME")] = "whisper"
    wake_word: Annotated[str, Argument("WORD")] = ""
    watch: Annotated[str | None, Argument("PORT", bare=PAGE_PORT)] = None
    host: Annotated[str | None, Argument("ADDRESS")] = None
    tls_cert: Annotated[str | None, Argument("FILE", files=("*",))] = None
    tls_key: Annotated[str | None, Argument("FILE", files=("*",))] = None
    ros_args: Annotated[tuple[str, ...], Argument("…", takes_rest=True)] = ()
