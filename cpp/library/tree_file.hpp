// Trees in files, in the format that Python's `Tree.save` writes: src/fastlines/support/container.py explains it.
#pragma once

#include <string>

#include "engine.hpp"

namespace fl::detail {

/// Write a tree; the file appears whole or not at all. Throws FileError.
void write_tree(const TreeImpl& tree, const std::string& path);

/// Read a tree over lines, and check it. Throws FileError.
TreePointer read_tree(const std::string& path);

}  // namespace fl::detail
