# SPDX-License-Identifier: Apache-2.0
"""`rai-missions campaign`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from rai_missions.cli.command import Argument, command

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rai_missions.campaign.intake import Progress
    from rai_missions.campaign.load import LoadedCampaign
    from rai_missions.campaign.pool import TaskPool
    from rai_missions.campaign.run import CampaignResult
    from rai_missions.campaign.tasks import WorkSettings

__all__ = ("CampaignOptions", "campaign")

MOST_REASONS, LONGEST_REASON = 3, 300
"""How many reasons of failed cells are printed after a run, and how many characters of each."""


class CampaignOptions(NamedTuple):
    """What a campaign takes.

    Args:
        subcommand: run: ask what is missing in the store; check: read the file and all that it names, and count the
            cells; label: label the scenes alone; report: write the report of a store; compare: what is better in one
            of two stores, and what is noise.
        file: For run, check and label the campaign's file; for report and compare a store.
        other: For compare: the other store.
        store: Where the results are. Without it: the name of the campaign with .db, in the working directory.
        jobs: How many workers. Without it: one a core.
        ray: Have Ray do the work, on the cluster at this address; without an address on this machine.
        model: Instead of those of the file: rules, oracle, constant:OPTION, PROVIDER:NAME or local; may be repeated.
        seconds: Wall time of this run, instead of the file's budget of it: what is left is for the next run.
        replay_answers: Judge the answers in this store again; no model is asked.
        report: Where the report goes, an HTML file, with .md and .csv next to it. For report, without it: the store's
            name with .html.
    """

    subcommand: Annotated[Literal["run", "check", "label", "report", "compare"], Argument(is_positional=True)]
    file: Annotated[str, Argument("FILE", is_positional=True, files=("*.json", "*.db"))]
    other: Annotated[str | None, Argument("RESULTS", is_positional=True, files=("*.db",))] = None
    store: Annotated[str | None, Argument("RESULTS", files=("*.db",))] = None
    jobs: Annotated[int | None, Argument("N")] = None
    ray: Annotated[str | None, Argument("ADDRESS", bare="")] = None
    model: tuple[Annotated[str, Argument("MODEL")], ...] = ()
    seconds: Annotated[float | None, Argument("S")] = None
    replay_answers: Annotated[str | None, Argument("RESULTS", files=("*.db",))] = None
    report: Annotated[str | None, Argument("REPORT", files=("*.html",))] = None


@command()
def campaign(options: CampaignOptions) -> int:
    """Measure which model may decide: a mission's own question, put to models in many simulated scenes.

    Each answer is judged by the mission's rules. What was answered is in one SQLite file: a campaign that was stopped
    or killed asks the rest when the same command is given again.

    Exit status:
        0 every cell was asked, 1 cells failed or the budget was spent, 2 the input is at fault

    Example:
        rai-missions campaign run campaigns/quick.json --store quick.db --report quick.html
    """
    from rai_missions.errors import UsageError

    if (options.subcommand == "compare") != (options.other is not None):
        raise UsageError("compare needs two stores: rai-missions campaign compare A.db B.db; the others take one file")
    if options.subcommand == "compare":
        from rai_missions.campaign.compare import compare

        print(compare(options.file, str(options.other)).text())
        return 0
    if options.subcommand == "report":
        return _report(options.file, options.report)
    return _check(options) if options.subcommand == "check" else _run(options)


def _report(store: str, page: str | None) -> int:
    from pathlib import Path

    from rai_missions.cli.campaign_report import write_report

    for path in write_report(store, page or Path(store).with_suffix(".html")):
        print(path)
    return 0


def _check(options: CampaignOptions) -> int:
    from rai_missions.campaign.checks import faults_at_work
    from rai_missions.campaign.plan import plan_of
    from rai_missions.errors import DefinitionError, counted

    loaded = _loaded(options)
    if found := tuple(faults_at_work(loaded.file, loaded.subject)):
        raise DefinitionError(found, options.file)
    plan, file = plan_of(loaded), loaded.file
    print(
        f"{file.name}: {counted(len(plan.cells), 'cell')}: {counted(len(plan.scenes), 'scene')}"
        f" × {counted(len(file.models), 'model')} × {counted(len(file.embodiments), 'embodiment')}"
        f" × {counted(len(file.orders), 'order')} of options"
    )
    return 0


def _loaded(options: CampaignOptions) -> LoadedCampaign:
    from rai_missions.campaign.load import load_campaign
    from rai_missions.errors import UsageError

    loaded = load_campaign(options.file, models=options.model)
    if options.seconds is None:
        return loaded
    if not options.seconds > 0:
        raise UsageError(f"--seconds is the wall time of the run, above 0, not {options.seconds:g}")
    budget = loaded.file.budget.model_copy(update={"seconds": options.seconds})
    return loaded._replace(file=loaded.file.model_copy(update={"budget": budget}))


def _run(options: CampaignOptions) -> int:
    import sys
    from pathlib import Path

    from rai_missions.campaign.run import run_campaign
    from rai_missions.campaign.store import ResultStore
    from rai_missions.cli.campaign_report import report_files
    from rai_missions.cli.long_work import LongWork
    from rai_missions.errors import counted

    loaded, settings, open_pool = _loaded(options), _settings(options), _pool(options)
    if options.report is not None:
        report_files(options.report)  # what cannot be written is known before anyone is asked
    path = Path(options.store or f"{loaded.file.name}.db")
    shown = ["the campaign begins"]

    def note(progress: Progress) -> None:
        shown[0] = progress.words(loaded.file.currency)

    with ResultStore(path, writes=True) as store, LongWork(lambda: shown[0]):
        try:
            result = run_campaign(
                loaded,
                store,
                settings,
                open_pool=open_pool,
                labels_alone=options.subcommand == "label",
                on_progress=note,
            )
        except KeyboardInterrupt:
            print(f"{shown[0]}; it is in {path}, and the same command continues there", file=sys.stderr)
            raise
        labelled = len(store.labels())
    unlabelled = _reasons(lambda count: f"{counted(count, 'scene')} without labels", result.unlabelled)
    if options.subcommand == "label":
        print(
            _words(result, path, [f"{counted(labelled, 'scene')} with labels", f"{result.missing} without"])
            + unlabelled
        )
        return 1 if result.missing else 0
    print(_words(result, path, _cell_counts(result)) + _reasons("{} failed".format, result.failures) + unlabelled)
    if options.report is not None:
        _report(str(path), options.report)
    return 1 if result.missing or result.counts.get("failed") else 0


def _settings(options: CampaignOptions) -> WorkSettings:
    """What the workers know."""
    from pathlib import Path

    from rai_missions.campaign.pool import usable_cores
    from rai_missions.campaign.tasks import WorkSettings
    from rai_missions.errors import UsageError

    if options.jobs is not None and options.jobs < 1:
        raise UsageError(f"--jobs is how many workers there are, 1 or more, not {options.jobs}")
    recorded = str(Path(options.replay_answers).resolve()) if options.replay_answers else ""
    return WorkSettings(str(Path(options.file).resolve()), options.model, options.jobs or usable_cores(), recorded)


def _pool(options: CampaignOptions) -> Callable[[WorkSettings], TaskPool]:
    """Who does the work."""
    from functools import partial

    if options.ray is not None:
        from rai_missions.campaign.ray_pool import RayPool

        return partial(RayPool, address=options.ray)
    from rai_missions.campaign.pool import LocalPool

    return LocalPool


def _cell_counts(result: CampaignResult) -> list[str]:
    from rai_missions.errors import counted

    counts = result.counts
    parts = [
        f"{counted(counts.get('answered', 0), 'cell')} answered",
        f"{counts.get('no_answer', 0)} without an answer",
    ]
    parts += [f"{failed} failed"] if (failed := counts.get("failed", 0)) else []
    return [*parts, f"{result.missing} not asked"] if result.missing else parts


def _words(result: CampaignResult, path: object, counts: Iterable[str]) -> str:
    """What a run has come to: its counts, what stopped it, and where they are."""
    why = f"; {result.stopped}" if result.stopped else ""
    return f"{', '.join(counts)}, in {result.seconds:.1f} s{why}; results: {path}"


def _reasons(how_many: Callable[[int], str], counts: Mapping[str, int]) -> str:
    """The most frequent reasons, each in a line with how often it was, in words."""
    most = list(counts.items())[:MOST_REASONS]
    return "".join(f"\n  {how_many(count)}: {_printed(why)}" for why, count in most)


def _printed(error: str) -> str:
    """What a model or a package wrote, in a line that a terminal prints as it is."""
    from rai_missions.plain_data import printable
    from rai_missions.redaction import cut

    return printable(cut(error, LONGEST_REASON), " ")
