# SPDX-License-Identifier: Apache-2.0
"""`rai-missions completion`."""

from __future__ import annotations

from typing import Any, Literal

from rai_missions.cli.command import command

__all__ = ("completion",)


@command(draws=True)
def completion(shell: Literal["bash", "zsh", "fish"]) -> int:
    """Print what lets a shell complete commands, options, choices and files.

    Args:
        shell: The shell that reads it.

    Exit status:
        0 it was printed, 2 the input is at fault

    Example:
        rai-missions completion bash > ~/.local/share/bash-completion/completions/rai-missions
        rai-missions completion zsh > ~/.zsh/completions/_rai-missions
        rai-missions completion fish > ~/.config/fish/completions/rai-missions.fish
    """
    import shtab

    from rai_missions.cli.commands import whole_parser

    def files(*patterns: str) -> dict[str, Any]:
        found: dict[str, Any] = shtab.glob(*patterns)
        if len(patterns) == 1:  # a lone pattern in parentheses would be a qualifier of zsh, which matches no file
            found["zsh"] = f"_files -g '{patterns[0]}'"
        return found

    print(shtab.complete(whole_parser(files), shell))
    return 0
