"""Measures of light return: functions of paths, one file a measure."""
