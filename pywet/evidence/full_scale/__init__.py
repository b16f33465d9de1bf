"""The paper's cases at full scale: campaign, kept tables, statements, page."""
