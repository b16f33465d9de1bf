"""The columns of the table: programs, and what they are called on the page."""

EXACT, REFERENCE, LIGGGHTS, YADE, WASHINO, EASO = "exact", "reference", "liggghts", "yade", "washino", "easo"
COLUMNS = {
    EXACT: "exact solution",
    REFERENCE: "independent reference",
    LIGGGHTS: "LIGGGHTS + pywet",
    YADE: "YADE",
    WASHINO: "stock washino",
    EASO: "stock easo",
}
