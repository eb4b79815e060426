// The Python modules fastlines._engine_*, one for each instruction set.
#include "engine.hpp"

NB_MODULE(FASTLINES_MODULE, m) { fastlines::bind_engine(m); }
