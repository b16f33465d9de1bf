"""The one exception a user's mistake raises: one sentence naming what was given, what was expected and where to mend it."""


class PywetError(Exception):
    """A mistake the user can mend; its text is one sentence, shown without a traceback."""


class NotWhole(PywetError):
    """Raw output of a run that does not hold what was planned: nothing can be made of it, the run has to be done again."""
