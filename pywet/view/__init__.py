"""What a person looks at: VTK files, pictures, curves and the report."""
