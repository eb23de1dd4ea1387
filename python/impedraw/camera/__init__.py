"""Depth images of real cameras: captures of them, and where the cameras stand. Needs the extra ``camera``."""
