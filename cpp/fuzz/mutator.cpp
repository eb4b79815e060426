// Mutates files as an attacker does, who knows the format: checksums and lengths are right again after most changes, so
// that fuzzers reach the checks behind them.
#include "accepted.hpp"
#include "changes.hpp"

namespace fastlines::fuzz {
namespace {

/// Changes a file that has parts, and puts it together again. Returns its size; 0 if it has become too large.
std::size_t change_parts(FileParts& file, const FileParts* other, std::uint8_t* data, std::size_t max_size,
                         test::Random& random) {
  Changes changes(file, other, random);
  // Half of all files are changed once.
  do changes.change();
  while (random.below(2));
  try {
    const std::vector<std::byte> bytes = file.together();
    if (bytes.size() > max_size) return 0;
    std::ranges::copy(std::as_bytes(std::span(bytes)), reinterpret_cast<std::byte*>(data));
    return bytes.size();
  } catch (const std::length_error&) {
    return 0;
  }
}

std::size_t mutate(std::uint8_t* data, std::size_t size, std::size_t max_size, std::span<const std::uint8_t> other,
                   unsigned seed) {
  test::Random random{seed};
  // Half of all changes start from a file that was accepted. So faults do not add up from file to file.
  if (const auto& kept = accepted.kept(); !kept.empty() && random.below(2)) {
    const Accepted::File& from = kept[random.below(kept.size())];
    if (from.size() <= max_size) {
      std::ranges::copy(from, data);
      size = from.size();
    }
  }
  // Bytes are changed anywhere, so that checksums and lengths are wrong.
  if (random.below(32) == 0) return LLVMFuzzerMutate(data, size, max_size);
  std::optional<FileParts> file = FileParts::of(std::as_bytes(std::span(data, size)));
  if (!file) return LLVMFuzzerMutate(data, size, max_size);
  const auto lender = other.empty() || random.below(4) ? std::nullopt : FileParts::of(std::as_bytes(other));
  try {
    const std::size_t changed = change_parts(*file, lender ? &*lender : nullptr, data, max_size, random);
    return changed ? changed : size;
  } catch (const std::runtime_error&) {
    return size;  // an invalid shape or type
  }
}

}  // namespace
}  // namespace fastlines::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return fastlines::fuzz::mutate(data, size, max_size, {}, seed);
}

extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* data, std::size_t size, const std::uint8_t* other,
                                                 std::size_t other_size, std::uint8_t* out, std::size_t max_size,
                                                 unsigned seed) {
  if (size > max_size) return 0;
  std::memcpy(out, data, size);
  return fastlines::fuzz::mutate(out, size, max_size, {other, other_size}, seed);
}
