"""The columns of the table: programs, and what they are called on the page."""

EXACT, REFERENCE, LIGGGHTS, YADE, WASHINO, EASO = "exact", "reference", "liggghts", "yade", "washino", "easo"
LAMMPS = "lammps"
COLUMNS = {
    EXACT: "exact solution",
    REFERENCE: "independent reference",
    LIGGGHTS: "LIGGGHTS + pywet",
    LAMMPS: "LAMMPS + pywet",
    YADE: "YADE",
    WASHINO: "stock washino",
    EASO: "stock easo",
}
