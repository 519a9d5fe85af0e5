"""The league: attitude filters of other libraries over shipped cases."""
