"""Writes files of states for these tests, and reads files of results."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mechanisms import random_states


def names_of(m, what):
    return m.coordinate_names if what == "q" else m.velocity_names


def lists(x):
    return pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(x).ravel()), x.shape[1])


def state_columns(m, state, layout="lists"):
    """The columns of a table from a dict of arrays: lists of fixed length, lists of any length, or one column for
    each coordinate as in run.csv."""
    columns = {}
    for what, x in state.items():
        if x.ndim == 1:
            columns[what] = pa.array(x)
        elif layout == "coordinates":
            columns |= {f"{what} {name}": pa.array(np.ascontiguousarray(x[:, k])) for k, name in enumerate(names_of(m, what))}
        else:
            columns[what] = lists(x) if layout == "lists" else pa.array(list(x))
    return columns


def states(m, N, seed=0):
    q, v, a, tau = random_states(m, N, seed)
    return {"t": np.arange(N) * 1e-3, "q": q, "v": v, "a": a, "tau": tau}


def write(file, m, state, layout="lists", **options):
    file.parent.mkdir(exist_ok=True)
    pq.write_table(pa.table(state_columns(m, state, layout)), file, **options)
    return file


def read(path, name):
    """A column of a file, or of all files of a folder in their order, as an array."""
    files = sorted(path.glob("*.parquet")) if path.is_dir() else [path]
    column = pa.concat_tables([pq.ParquetFile(file).read() for file in files]).column(name).combine_chunks()
    if isinstance(column.type, pa.FixedShapeTensorType):
        return column.to_numpy_ndarray()
    if pa.types.is_fixed_size_list(column.type):
        return column.flatten().to_numpy().reshape(len(column), -1)
    return column.to_numpy(zero_copy_only=False)


def same(x, y):
    """Whether two arrays are equal to the last bit."""
    return x.dtype == y.dtype and x.shape == y.shape and x.tobytes() == np.ascontiguousarray(y).tobytes()
