"""Studies of the whole workflow: what accuracy costs, where runs stay stable, what each effect contributes."""
