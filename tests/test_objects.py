# SPDX-License-Identifier: Apache-2.0
"""What belongs to an object is changed by that object: no function changes a module's, nor another object's."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.rigs.sources import nodes, parsed

ROOT = Path(__file__).parents[1]
OURS = ("rai_missions", "visualize")
CHANGES = frozenset(
    (
        "add", "append", "appendleft", "clear", "difference_update", "discard", "extend", "extendleft", "insert",
        "intersection_update", "move_to_end", "pop", "popitem", "popleft", "remove", "reverse", "rotate", "setdefault",
        "sort", "symmetric_difference_update", "update",
    )
)  # fmt: skip
"""Methods that change a list, a set, a dict or a deque."""
SWITCHES = frozenset(
    (
        "atexit.register", "faulthandler.enable", "gc.disable", "gc.freeze", "gc.set_threshold", "locale.setlocale",
        "logging.basicConfig", "logging.disable", "logging.setLogRecordFactory", "logging.setLoggerClass", "os.chdir",
        "os.nice", "os.putenv", "os.umask", "random.seed", "resource.setrlimit", "signal.signal",
        "socket.setdefaulttimeout", "sys.setrecursionlimit", "sys.setswitchinterval", "threading.setprofile",
        "threading.settrace", "warnings.filterwarnings", "warnings.simplefilter",
    )
)  # fmt: skip
"""Functions that change the whole process."""

PROCESS = "the process was started for this alone, and ends with it"
READS = "a library reads nothing but the variables of the process, once, when it begins"
GLOBALS = {
    ("rai_missions/campaign/ray_pool.py", "os.environ"): PROCESS,
    ("rai_missions/campaign/worker.py", "os.environ"): PROCESS,
    ("rai_missions/campaign/worker.py", "sys.path"): PROCESS,
    ("rai_missions/answerers/model/gguf_process.py", "os.environ"): PROCESS,
    ("rai_missions/answerers/model/process/worker.py", "os.environ"): PROCESS,
    ("rai_missions/answerers/model/process/worker.py", "sys.path"): PROCESS,
    ("rai_missions/connectors/ros2/fastdds.py", "os.environ"): f"{READS}; it is put back at once",
    ("rai_missions/connectors/process/idle_threads.py", "os.environ"): READS,
    ("rai_missions/worlds/libraries.py", "os.environ"): READS,
    ("rai_missions/cli/main.py", "atexit.register"): f"{PROCESS}; a caller of `main` with words keeps its own",
    ("rai_missions/cli/main.py", "os.environ"): f"{PROCESS}; pydantic's plug-ins have no other switch",
    ("rai_missions/cli/streams.py", "sys"): "a command needs streams that are there; they are put back at its end",
    ("rai_missions/connectors/process/guard.py", "os.nice"): PROCESS,
    ("rai_missions/connectors/process/guard.py", "signal.signal"): PROCESS,
    ("rai_missions/voice/recognisers/whisper.py", "os.environ"): PROCESS,
    ("rai_missions/voice/voices/kokoro.py", "os.environ"): PROCESS,
    ("rai_missions/voice/worker.py", "sys.path"): PROCESS,
    ("rai_missions/embodiment/reading_process.py", "resource.setrlimit"): PROCESS,
    ("rai_missions/embodiment/minilm.py", "os.environ"): f"{READS}; a maker's telemetry has no other switch",
    ("rai_missions/worlds/perception/__main__.py", "signal.signal"): PROCESS,
    ("rai_missions/connectors/ros2/connector.py", "atexit.register"): "taken back when it stops",
    (
        "rai_missions/mission/garbage.py",
        "gc.freeze",
    ): "thawed at once, or when a command's run is over; left alone where something is frozen",
    ("rai_missions/mission/garbage.py", "gc.set_threshold"): "put back when the last one has built",
    ("rai_missions/recording/recording.py", "atexit.register"): "taken back when it closes",
    ("rai_missions/runtime/interrupts.py", "signal.signal"): "put back when the run ends",
    ("rai_missions/engine/activities/activity.py", "_remembered"): "filled as classes are defined, like the classes",
    ("rai_missions/profile/python_robot.py", "sys.path"): "put back when the file that a person named was executed",
    ("rai_missions/mission/python_file.py", "sys.modules"): "the interpreter looks a class's module up there",
    ("rai_missions/redaction.py", "_living"): "weak: each entry lives as long as the object that holds its secrets",
}
"""A module, and an object of the module or of the interpreter that its functions change → why."""

RUN_STATE = "the engine is functions over a program and a run's state, which has no methods of its own"
STATES = frozenset(("draft", "state", "state.draft", "self._chart.state", "self._chart.state.draft"))
"""What a `RunState` and its draft are called in `engine` and `prove`; there their fields are assigned."""
THIRD = "an object of another library, which is set up so"
NODES = "made there with its children, and linked once they are all there"
PROOF = "a part of one proof, put together and counted by it"
RECORD = "a running action of the same package: a record without methods"
SHARED = {
    ("rai_missions/answerers/model/gguf_process.py", "cores"): THIRD,
    ("rai_missions/answerers/model/gguf_process.py", "wanted.model"): THIRD,
    ("rai_missions/connectors/process/life.py", "process"): THIRD,
    ("rai_missions/cli/command.py", "action"): THIRD,
    ("rai_missions/cli/streams.py", "sys"): "streams that the caller has closed, put back at a command's end",
    ("rai_missions/connectors/ros2/services.py", "response"): THIRD,
    ("rai_missions/connectors/ros2/messages.py", "message"): "a message of ROS, just made by its caller",
    ("rai_missions/trees/builder.py", "behaviour"): "made by the caller, who gives it away with all that it needs",
    ("rai_missions/journal/sqlite_reader.py", "connection"): "of a class of sqlite3's, with a note of what was cut off",
    ("rai_missions/redaction.py", "record"): THIRD,
    ("rai_missions/trees/ticker.py", "node"): THIRD,
    ("visualize/graphviz.py", "dot_command"): THIRD,
    ("visualize/live/server.py", "self._server"): THIRD,
    ("rai_missions/engine/compiled/mission.py", "node"): NODES,
    ("rai_missions/engine/compiled/mission.py", "self.nodes[name] if name else self.root"): NODES,
    ("rai_missions/engine/compiled/mission.py", "self.root"): NODES,
    ("rai_missions/engine/compiled/graph.py", "found"): NODES,
    ("rai_missions/engine/trees/build.py", "node"): NODES,
    ("rai_missions/engine/trees/ticker.py", "node"): "the live nodes of its own tree, put where a state has them",
    ("rai_missions/guards/named.py", "site"): "a site collects what guards report of it while they are compiled",
    ("rai_missions/trees/ticker.py", "sight"): "what a tick sees is put there before it",
    ("rai_missions/prove/__init__.py", "environment.codec"): PROOF,
    ("rai_missions/prove/abstraction/abstraction.py", "self._world.board"): PROOF,
    ("rai_missions/prove/verdicts/counterexample.py", "environment.control"): PROOF,
    ("rai_missions/prove/verdicts/counterexample.py", "environment.inputs"): PROOF,
    ("rai_missions/prove/environment/environment.py", "control"): PROOF,
    ("rai_missions/prove/exploration/explorer.py", "self.meter"): PROOF,
    ("rai_missions/prove/abstraction/instruments.py", "machine"): "hooks of the prover's own copy of a machine",
    ("rai_missions/prove/abstraction/instruments.py", "machine.ticker"): "hooks of the prover's own copy of a machine",
    ("rai_missions/prove/abstraction/instruments.py", "node"): "hooks of the prover's own copy of a program",
    ("rai_missions/prove/abstraction/open_world.py", "program"): "the prover's own copy of a program",
    ("rai_missions/prove/abstraction/state_key.py", "self._chart"): "the prover's own chart, whose state it loads",
    ("rai_missions/prove/environment/time_env.py", "codec"): PROOF,
    ("rai_missions/prove/verdicts/unrolled.py", "every.codec"): PROOF,
    ("rai_missions/worlds/desk/trajectory.py", "wanted"): THIRD,
    ("rai_missions/worlds/house/actions.py", "running"): RECORD,
    ("rai_missions/worlds/orchard/actions.py", "running"): RECORD,
    ("rai_missions/worlds/orchard/actions.py", "self.running"): RECORD,
}
"""A module, and what it assigns attributes of → why."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


@pytest.fixture(scope="module")
def found() -> tuple[set[tuple[str, str]], set[tuple[str, str]]]:
    """What functions change of modules, and of other objects: each with its module."""
    of_modules, of_others = set(), set()
    for path in (path for folder in OURS for path in sorted((ROOT / folder).rglob("*.py"))):
        name, tree = str(path.relative_to(ROOT)), parsed(path.read_text(encoding="utf-8"))
        of_modules |= {(name, what) for what in changed_globals(tree)}
        of_others |= {(name, what) for what in assigned(tree)}
    return of_modules, of_others


def functions(tree: ast.AST) -> Iterator[Function]:
    return (node for node in nodes(tree) if isinstance(node, Function))


def first_name(node: ast.expr) -> str:
    """`a` of `a.b[c].d`; empty where it does not begin with a name."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


def module_names(tree: ast.Module) -> set[str]:
    """The names that a module binds: by assignment, by `class`, and by `import`."""
    names = {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    names |= {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", ast.Constant(0))]
        names |= {each.id for target in targets for each in nodes(target) if isinstance(each, ast.Name)}
    return names


def local_names(function: Function) -> set[str]:
    arguments = {node.arg for node in nodes(function) if isinstance(node, ast.arg)}
    stored = {n.id for n in nodes(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    return (arguments | stored) - {name for n in nodes(function) if isinstance(n, ast.Global) for name in n.names}


def changed(function: Function) -> Iterator[tuple[str, str]]:
    """What a function changes in place: the name with which the expression begins, and the expression."""
    for node in nodes(function):
        if isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
            yield first_name(node), ast.unparse(node.value)
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "setattr":
            yield first_name(node.args[0]), ast.unparse(node.args[0])
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in CHANGES:
            if ast.unparse(node.func.value) == "np":  # its functions are called so, and change nothing of it
                continue
            yield first_name(node.func), ast.unparse(node.func.value)
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in SWITCHES:
            yield "", ast.unparse(node.func)
        elif isinstance(node, ast.Global):
            yield from ((name, name) for name in node.names)


def changed_globals(tree: ast.Module) -> set[str]:
    known = module_names(tree)
    found: set[str] = set()
    for function in functions(tree):
        outer = known - local_names(function)
        found |= {what for name, what in changed(function) if name in outer or what in SWITCHES}
    return found


def made(function: Function) -> set[str]:
    """The names that a function binds to an object that it has just made: by calling a class."""
    names: set[str] = set()
    for node in (each for each in nodes(function) if isinstance(each, ast.Assign)):
        values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
        if any(isinstance(each, ast.Call) and makes(each.func) for each in values):
            names |= {n.id for target in node.targets for n in nodes(target) if isinstance(n, ast.Name)}
    return names


def makes(what: ast.expr) -> bool:
    """It is a class by its name, or makes a copy."""
    name = ast.unparse(what).rpartition(".")[2].lstrip("_")
    return name[:1].isupper() or name in ("cls", "copy", "type(self)", "__new__", "finalize")


def declared(tree: ast.Module) -> set[str]:
    """The attributes of the classes that a module defines."""
    names: set[str] = set()
    for owner in (node for node in nodes(tree) if isinstance(node, ast.ClassDef)):
        for node in nodes(owner):
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                names.add(node.target.id)
            elif isinstance(node, ast.Attribute) and ast.unparse(node.value) == "self":
                names.add(node.attr)
    return names


def assigned(tree: ast.Module) -> set[str]:
    """The expressions, but for `self`, of whose value a function assigns an attribute.

    An object that the function has just made is its own, and so are those of classes that the module defines.
    """
    found, ours = set[str](), declared(tree)
    for function in functions(tree):
        own = made(function) | {"self", "cls"}
        found |= {
            ast.unparse(node.args[0])
            for node in nodes(function)
            if isinstance(node, ast.Call)
            and ast.unparse(node.func) == "setattr"
            and ast.unparse(node.args[0]) not in own
        }
        found |= {
            ast.unparse(node.value)
            for node in nodes(function)
            if isinstance(node, ast.Attribute)
            and not isinstance(node.ctx, ast.Load)
            and ast.unparse(node.value) not in own
            and node.attr not in ours
        }
    return found


Found = tuple[set[tuple[str, str]], set[tuple[str, str]]]


def test_no_function_changes_what_belongs_to_a_module(found: Found) -> None:
    assert found[0] - GLOBALS.keys() == set()


def test_no_function_assigns_the_attributes_of_another_object(found: Found) -> None:
    run_states = {each for each in found[1] if each[1] in STATES and each[0].split("/")[1] in ("engine", "prove")}
    assert found[1] - run_states - SHARED.keys() == set(), RUN_STATE


def test_no_reason_is_left_over(found: Found) -> None:
    assert (GLOBALS.keys() - found[0], SHARED.keys() - found[1]) == (set(), set())


def test_what_changes_a_module_or_another_object_is_found() -> None:
    tree = ast.parse(
        "import os\nKNOWN = {}\nNUMBER = 0\n"
        "def learn(name): KNOWN[name] = 1\n"
        "def forget(): KNOWN.clear()\n"
        "def advance():\n    global NUMBER\n    NUMBER += 1\n"
        "def keep(KNOWN): KNOWN.clear()\n"
        "def show(): os.environ['A'] = '1'\n"
        "def close(other): other.is_open = False\n"
        "def mark(mine): setattr(mine, 'is_open', False)\n"
        "def open_all(): os.umask(0)\n"
        "def keep_some(): KNOWN.intersection_update({})\n"
        "def make():\n    other = Thing()\n    other.is_open = False\n"
        "def count(thing): thing.number = 1\n"
        "class Thing:\n    number: int\n    def end(self): self.is_shut = self.inner.is_done = False\n"
    )
    assert changed_globals(tree) == {"KNOWN", "NUMBER", "os.environ", "os.umask"}
    assert assigned(tree) == {"mine", "other", "self.inner"}
