"""The bars that long calls show."""

from __future__ import annotations

from typing import Any

__all__: list[str] = []


def progress_bar(total: float, **options: Any) -> Any:
    """A bar of tqdm. ImportError, with the remedy, if there is no tqdm."""
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped, import-not-found, unused-ignore]
    except ImportError as error:
        raise ImportError("progress=True shows a bar of tqdm, which is not installed: pip install tqdm") from error
    return tqdm(total=total, **options)
