"""How fast queries are: beside Embree and other versions, by steps, by shapes, and as the scene or the radius grows."""
