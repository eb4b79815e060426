// Trees in files, in the format that Python's `Tree.save` writes.
#pragma once

#include <functional>
#include <string>

#include "container.hpp"
#include "engine.hpp"

namespace fl::detail {

/// Call write(parts) with the parts of a tree's file. Throws std::length_error if its header would be too long.
void write_tree(const TreeImpl& tree, const std::function<void(const std::vector<Bytes>&)>& write);

/// The tree over lines that a file has, after all checks. The file begins at a multiple of 8 bytes. Throws a
/// std::exception that says why it is not usable.
TreePointer read_tree(Bytes file, const Engine& engine);

/// Save a tree; the file appears whole or not at all. Throws FileError.
void save_tree(const TreeImpl& tree, const std::string& path);

/// Load a tree over lines, and check it. Throws FileError.
TreePointer load_tree(const std::string& path);

}  // namespace fl::detail
