// Reads and writes files as a whole.
#include "whole_file.hpp"

#include <filesystem>
#include <fstream>
#include <random>

#include "fastlines/api/tree.hpp"

namespace fl::detail {
namespace {

/// The file that a path names, past symbolic links, whether it exists or not; nothing but a file may be replaced.
std::filesystem::path target_of(const std::string& path) {
  namespace fs = std::filesystem;
  constexpr int most_links = 40;  // as many as Linux follows
  std::error_code error;
  fs::path target = path;
  for (int i = 0; fs::is_symlink(fs::symlink_status(target, error)); ++i) {
    if (i == most_links) throw FileError(path + " is a loop of symbolic links; expected the path of a file to write");
    target = target.parent_path() / fs::read_symlink(target, error);
  }
  const fs::file_status status = fs::status(target, error);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw FileError(path + " is not a regular file; expected the path of a file to write");
  return target;
}

}  // namespace

std::vector<std::byte> read_file(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) throw FileError(path + " cannot be read; expected the path of a tree file (.flt)");
  std::vector<std::byte> bytes(size);
  file.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size));
  if (!file) throw FileError(path + " cannot be read to its end");
  return bytes;
}

void write_file(const std::string& path, const std::vector<Bytes>& parts) {
  namespace fs = std::filesystem;
  constexpr std::size_t most_characters = 50;  // of its name, as file systems limit the length of names
  if (path.empty()) throw FileError("the path is empty; expected the path of a file to write");
  const fs::path target = target_of(path);
  const std::string name = target.filename().string().substr(0, most_characters);
  const fs::path partial = target.parent_path() / (name + "." + std::to_string(std::random_device{}()) + ".partial");
  std::ofstream file(partial, std::ios::binary);
  if (!file)
    throw FileError(path + " cannot be written; expected a path in a folder that exists and can be written to");
  // Keep the mode, before there is anything to read.
  std::error_code error;
  const fs::file_status before = fs::status(target, error);
  error.clear();
  if (fs::exists(before)) fs::permissions(partial, before.permissions() & fs::perms(0777), error);
  if (!error)
    for (const Bytes part : parts) file.write(reinterpret_cast<const char*>(part.data()), std::streamsize(part.size()));
  file.close();
  if (file && !error) fs::rename(partial, target, error);
  if (!file || error) {
    std::error_code ignored;
    fs::remove(partial, ignored);
    throw FileError(path + " cannot be written: " + (error ? error.message() : "the disk may be full"));
  }
}

}  // namespace fl::detail
