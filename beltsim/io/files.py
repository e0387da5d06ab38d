"""Files that appear whole or not at all, and folders checked before the work begins.

Depends on: errors.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from beltsim.errors import ResultFileError


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give a temporary name beside `path`; move it there when the block ends without error.

    The content is flushed to the disk before the move, so a crash leaves the old file or the new
    one, never a part. An error, Ctrl-C included, removes the temporary file.

    Parameters
    ----------
    path : str or Path
        Where the file is to appear. An existing file is replaced.

    Yields
    ------
    Path
        The temporary name; it keeps the suffix of `path`.

    Raises
    ------
    ResultFileError
        When the folder cannot be written to, or the disk refuses the content.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with whole_file(folder / "note.txt") as temporary:
    ...     _ = temporary.write_text("done")
    >>> [file.name for file in folder.iterdir()]
    ['note.txt']
    """
    target = Path(path)
    temporary = target.with_name(f".{target.stem}.{secrets.token_hex(6)}{target.suffix}")
    try:
        yield temporary
        _flush(temporary)
        temporary.replace(target)
        _flush(target.parent)
    except OSError as error:
        raise ResultFileError(f"cannot write {target}: {_reason(error)}") from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def require_writable(folder: str | Path) -> Path:
    """Prove that a file can be made in `folder`, which need not exist yet; leave no trace.

    Raises
    ------
    ResultFileError
        Naming the folder and what the system says.

    Examples
    --------
    >>> import tempfile
    >>> place = require_writable(tempfile.mkdtemp() + "/new")
    >>> place.exists()
    False
    """
    place = Path(folder)
    missing = [part for part in (place, *place.parents) if not part.exists()]
    probe = place / f".beltsim-{secrets.token_hex(6)}"
    try:
        place.mkdir(parents=True, exist_ok=True)
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        text = f"output folder {place} cannot be written to ({_reason(error)}); choose another"
        raise ResultFileError(text) from error
    finally:
        with suppress(OSError):
            for part in missing:
                part.rmdir()
    return place


def _flush(path: Path) -> None:
    """Ask the system to put `path`, a file or a folder, on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _reason(error: OSError) -> str:
    return error.strerror or str(error) or type(error).__name__
