"""A spherical camera and correct AOVs for Mitsuba 3. Importing this registers the plugins `equirect` and `equirect_aov`."""
