"""Tables of a motion: CSV and npz."""
