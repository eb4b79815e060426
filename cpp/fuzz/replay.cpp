// Runs a fuzzer's program on the files of a corpus, without libFuzzer. At least an eighth of them has to be accepted.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "accepted.hpp"
#include "tests/check.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main(int argc, char** argv) {
  using namespace fastlines;
  if (!test::has_simd()) return test::kSkipped;
  std::size_t n_files = 0;
  for (int i = 1; i < argc; ++i)
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      std::ifstream file(entry.path(), std::ios::binary);
      const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
      std::printf("%s\n", entry.path().filename().c_str());
      std::fflush(stdout);  // so that the last line names the file that ends the program
      LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
      ++n_files;
    }
  std::printf("%zu files: no crash, no wrong answer\n", n_files);
  return fuzz::accepted.count() == 0 || fuzz::accepted.count() < n_files / 8;
}
