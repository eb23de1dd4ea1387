"""Pictures as lines of a pen: tone as hatches, one line through stipples, a flow or contours, and
the centre lines of what is drawn. ``python -m impedraw.image`` is the command ``impedraw image``."""
