"""Photon beams: the gather beside its peers, progressive passes, a closed form, and a caustic beside Mitsuba's."""
