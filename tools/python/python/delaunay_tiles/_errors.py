"""The exceptions of the package."""


class Error(Exception):
    """The base of the package's own exceptions.

    Faults of the system are not among them: they are `OSError`, `FileNotFoundError`, `PermissionError` and
    `FileExistsError`. An argument of the wrong type is a `TypeError`, one of a wrong value a `ValueError`.
    """


class BuildError(Error, ValueError):
    """The input has no (constrained) Delaunay triangulation as asked for: lines cross, a ring does not close."""


class EditError(Error, ValueError):
    """A file cannot be changed as asked for: a point is not there, or has no z. The file is unchanged."""


class FileError(Error):
    """A file is no tile file, is damaged, or has a version that this package does not support."""


class InputError(Error, ValueError):
    """A file of points, lines or sites cannot be read, or a record in it is invalid."""


class MemoryLimitError(Error, MemoryError):
    """The memory that was allowed does not suffice; the message says how much does."""


class QueryError(Error, ValueError):
    """The file cannot answer the question, such as one for heights in a file without z."""


class VerifyError(Error):
    """A tile file contradicts itself, or is not the (constrained) Delaunay triangulation."""


for _exception in (Error, BuildError, EditError, FileError, InputError, MemoryLimitError, QueryError, VerifyError):
    _exception.__module__ = "delaunay_tiles"
