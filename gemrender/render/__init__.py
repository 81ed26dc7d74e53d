"""Mitsuba at work: variants, scored maps."""
