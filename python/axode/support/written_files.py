"""Files that are replaced as a whole or left as they were."""

from __future__ import annotations

import contextlib
import os
import uuid
from collections.abc import Iterator
from pathlib import Path

__all__: list[str] = []

MOST_LINKS = 40  # the limit of Linux


def _replaceable(path: Path) -> Path | None:
    """The file to which symbolic links lead; it need not exist. None for files that must be written directly:
    devices, pipes and links of /proc to the open files of processes, such as /dev/stdout."""
    if path.exists() and not path.is_file():
        return None
    for _ in range(MOST_LINKS):
        if not path.is_symlink():
            break
        folder = path.parent.resolve()
        if folder.is_relative_to("/proc"):
            return None
        path = folder / os.readlink(path)
    return path


def _take_permissions(new: Path, old: Path) -> None:
    """Gives the new file the owner, the group and the permissions of the old one, as far as the user may."""
    status = old.stat()
    for owner, group in [(status.st_uid, -1), (-1, status.st_gid)]:
        with contextlib.suppress(OSError):
            os.chown(new, owner, group)
    with contextlib.suppress(OSError):
        new.chmod(status.st_mode & 0o7777)


@contextlib.contextmanager
def replacing(path: Path, folder: Path | None = None) -> Iterator[Path]:
    """Yields a new file to write, in the folder or beside the path. At the end it replaces the path; after an
    exception it is removed, and the path is as it was. The permissions of an existing file are kept, a symbolic link
    stays and its target is replaced. A device or a pipe is yielded itself."""
    target = _replaceable(path)
    if target is None:
        yield path
        return
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(f"{path} cannot be written: it is read-only")
    if not (folder or target.parent).is_dir():
        raise FileNotFoundError(f"{path} cannot be written: there is no folder {folder or target.parent}")
    temporary = (folder or target.parent) / f".{target.name}.{uuid.uuid4().hex}"
    try:
        yield temporary
        with temporary.open("rb") as stream:
            os.fsync(stream.fileno())
        if target.exists():
            _take_permissions(temporary, target)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)
