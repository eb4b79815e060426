"""What trees are over: containers of primitives, and how other data becomes one."""
