// The Python modules fastlines._engine_*.
#include "engine.hpp"

NB_MODULE(FASTLINES_MODULE, m) { fastlines::bind_engine(m); }
