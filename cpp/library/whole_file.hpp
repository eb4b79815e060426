// Files that are read and written as a whole.
#pragma once

#include <string>
#include <vector>

#include "container.hpp"

namespace fl::detail {

/// All bytes of a file. Throws FileError.
std::vector<std::byte> read_file(const std::string& path);

/// Write the parts of a file; it appears whole or not at all. Throws FileError.
void write_file(const std::string& path, const std::vector<Bytes>& parts);

}  // namespace fl::detail
