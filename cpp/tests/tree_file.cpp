// Tree files that lie, with right checksums: the library refuses them by a reason, and what it saves it reads again.
#include "library/tree_file.hpp"

#include "library.hpp"

using namespace fl::detail;

namespace {

using File = std::vector<std::byte>;

File bytes_of(const ContainerFile& file) {
  File bytes;
  for (const Bytes part : file.parts()) bytes.insert(bytes.end(), part.begin(), part.end());
  return bytes;
}

File saved(const TreeImpl& tree) {
  File bytes;
  write_tree(tree, [&](const std::vector<Bytes>& parts) {
    for (const Bytes part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
  });
  return bytes;
}

TreePointer read(const File& file) { return read_tree(file, current_engine()); }

std::string refusal(const File& file) {
  return message_of<std::exception>([&] { read(file); });
}

/// The same file with another text in its metadata.
File with_text(const File& file, const std::string& name, const std::string& text) {
  Container content = split(file);
  content.sections.pop_back();
  std::erase_if(content.metadata, [&](const auto& each) { return each.first == name; });
  content.metadata.emplace_back(name, text);
  return bytes_of(ContainerFile(content));
}

/// The settings with another text in the place of one.
File with_setting(const File& file, const std::string& from, const std::string& to) {
  std::string settings = split(file).text("settings");
  const std::size_t at = settings.find(from);
  check(at != std::string::npos, "the settings have what is to be replaced");
  return with_text(file, "settings", settings.replace(at, from.size(), to));
}

void check_metadata(const File& file) {
  for (const char* text : {"NaN", "-1", "Infinity", "-Infinity", "1e999", "\"1\"", "[]"})
    check(!refusal(with_text(file, "built_cost", text)).empty(), "an invalid cost of the build");
  for (const char* text : {"0", "1.5"})
    check(saved(*read(with_text(file, "built_cost", text))) ==
              saved(*read(saved(*read(with_text(file, "built_cost", text))))),
          "a cost of the build is kept");
  for (const char* text : {"NaN", "Infinity", "0", "-1", "1e101", "\"2\""})
    check(!refusal(with_setting(file, "\"c_prim\": 1", "\"c_prim\": " + std::string(text))).empty(),
          "an invalid cost of a primitive");
  check(refusal(with_setting(file, "\"c_prim\": 1", "\"c_prim\": -1"))
                .find("c_prim = -1; expected a number from 1e-100") != std::string::npos,
        "the error names the cost, and what it may be");
  check(!refusal(with_setting(file, "\"tight\"", "\"loose\"")).empty(), "an unknown rule of boxes");
  for (const char* text : {"", "3", "[]"})
    check(!refusal(with_text(file, "limits_hit", text)).empty(), "invalid limits");
  for (const char* text : {R"({"offset": [NaN, 0, 0]})", R"({"offset": [0, 0]})", R"({"offset": [0, Infinity, 0]})"})
    check(!refusal(with_text(file, "metadata", text)).empty(), "an invalid offset");
  for (const char* text : {"[[-9, -9, -9], [9, 9, NaN]]", "[[-9, -9, -9], [9, 9, 2e30]]", "[[9, 9, 9], [-9, -9, -9]]",
                           "[[0, 0, 0], [0, 0, 0]]", "[[-9, -9, -9]]", "null"})
    check(!refusal(with_text(file, "frame", text)).empty(), "a frame that is invalid, or does not hold the lines");
  check(refusal(with_text(file, "frame", "[[-9, -9, -9], [9, 9, 9]]")).empty(), "a frame that holds the lines");
}

/// A section cannot be as large as its header says, whatever that is.
void check_sizes(const File& file) {
  for (const char* shape :
       {"[1099511627776, 9]", "[9007199254740992]", "[-1, 9]", "[1.5, 9]", "[1e300]", "9", "[[9]]"}) {
    Container content = split(file);
    content.sections.pop_back();
    for (Section& section : content.sections)
      if (section.name == "nodes") section.shape = shape;
    check(!refusal(bytes_of(ContainerFile(content))).empty(), "a shape that is not that of its section");
  }
}

}  // namespace

int main() {
  return fastlines::test::run([] {
    const std::vector<fl::Segment> segments = segments_of(fastlines::test::hair(3));
    const File file = saved(*current_engine().build_segments(segments, {}));
    check(refusal(file).empty() && saved(*read(file)) == file, "a tree that is read is saved as the same file");
    check_metadata(file);
    check_sizes(file);
  });
}
