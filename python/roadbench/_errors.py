"""The errors that are not Python's own."""


class Error(Exception):
    """What roadbench refuses, with what to do in its message; the parent of the others."""


class Rejected(Error):
    """A log that cannot be used; the batch would write it to the table ``rejected``.

    Attributes:
        stage: where it was refused: ``discover``, ``ingest``, ...
        code: short stable name, e.g. ``truncated``.
        message: for people: what is wrong and what to do.

    Example:
        >>> try:
        ...     roadbench.run_session("broken.parquet", "bike.toml")
        ... except roadbench.Rejected as why:
        ...     print(why.code)
        truncated
    """

    def __init__(self, stage: str, code: str, message: str) -> None:
        super().__init__(stage, code, message)  # all three, so that it can be pickled
        self.stage = stage
        self.code = code
        self.message = message

    def __str__(self) -> str:
        return f"{self.stage}: {self.message} ({self.code})"
