"""Arrays of the time loop's named tuples, declared once: their shape, and whether a run changes them.

The annotation of a field is `state(shape)`, `given(shape)` or `room(shape)`; all else that arrays need follows from it:
what they begin with (`filled`), what a checkpoint keeps, what a model's digest is of (`fem.solver.row_state`). A field
that is plainly an array stands for one that belongs to another tuple.
"""

from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np

CACHE_LINE = 64  # bytes, as long as one register of eight: eight lanes that lie across two lines cost two accesses


class Field(NamedTuple):
    """Declaration of an array."""

    shape: str  # sizes by name, separated by commas
    kind: str  # "state": a run changes it; "given": the model determines it; "room": filled anew before it is read
    initial: float
    dtype: type


def _array(kind: str, shape: str, initial: float = 0.0, dtype: type = np.float64) -> Any:
    return Annotated[np.ndarray, Field(shape, kind, initial, dtype)]


state, given, room = (partial(_array, kind) for kind in ("state", "given", "room"))


def _field(kind: type, name: str) -> Field | None:
    (found,) = getattr(kind.__annotations__[name], "__metadata__", (None,))
    return found


def kind_of(group: tuple, name: str | int) -> str | None:
    """Whether a run changes an array of a named tuple, as `Field.kind`; None: not declared."""
    field = _field(type(group), name) if isinstance(name, str) else None
    return None if field is None else field.kind


def filled(kind: type, sizes: dict[str, int], **values: object) -> Any:
    """A named tuple with `values`, and arrays as declared where these lack one, which begin at cache lines.

    sizes : of the shapes' names

    Errors: TypeError: a field that is no array has no value. NameError: a size is missing.
    """
    for name in kind._fields:
        field = _field(kind, name)
        if name not in values and field is not None and name not in kind._field_defaults:
            shape = eval(f"({field.shape},)", {"__builtins__": {}}, sizes)  # of declarations in this package alone
            values[name] = at_line(np.full(shape, field.initial, dtype=field.dtype))
    return kind(**values)


def at_line(values: np.ndarray) -> np.ndarray:
    """A copy that begins at a cache line."""
    buffer = np.zeros(values.nbytes + CACHE_LINE, dtype=np.uint8)
    first = -buffer.ctypes.data % CACHE_LINE
    copy = buffer[first : first + values.nbytes].view(values.dtype).reshape(values.shape)
    copy[...] = values
    return copy


def lined_up(group: Any) -> Any:
    """A named tuple, and those in it, with copies of its arrays that begin at cache lines."""
    copied = (at_line(entry) if isinstance(entry, np.ndarray) else entry for entry in group)
    return type(group)(*(lined_up(entry) if hasattr(entry, "_fields") else entry for entry in copied))
