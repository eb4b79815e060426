"""What fastlines is measured beside: Embree, Mitsuba, Warp, and other versions of itself."""
