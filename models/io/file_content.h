#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace raybundle::io {

/// The bytes of a file, read only. A plain file is mapped, not copied; it must not be cut short by
/// others meanwhile. Pipes, devices and the like are read to their end.
class FileContent {
 public:
  /// Throws InputError naming `path` when there is nothing to read there.
  explicit FileContent(const std::filesystem::path& path);
  /// From an open descriptor, which stays open; `source` names it in errors.
  FileContent(int descriptor, const std::string& source);
  ~FileContent();
  FileContent(const FileContent&) = delete;
  FileContent& operator=(const FileContent&) = delete;

  std::string_view text() const { return text_; }

 private:
  void load(int descriptor, const std::string& source);
  bool map(int descriptor);

  std::string_view text_;
  void* mapping_ = nullptr;
  std::string copy_;
};

/// Bytes that a stream without a known size (a pipe, something compressed) may come to before it
/// is refused: half of this machine's memory.
std::int64_t largest_stream();

}  // namespace raybundle::io
