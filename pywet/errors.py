"""The one exception a user's mistake raises: one sentence naming what was given, what was expected and where to mend it."""


class PywetError(Exception):
    """A mistake the user can mend; its text is one sentence, shown without a traceback."""
