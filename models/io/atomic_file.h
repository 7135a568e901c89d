#pragma once

#include <filesystem>
#include <string_view>

namespace raybundle::io {

/// A file written whole or not at all. The bytes go to a temporary file in the same folder, which
/// takes the target's name in commit(); without commit() it vanishes and an earlier file of that
/// name stays as it was.
///
/// A target that is a link keeps being one: the file it points to is replaced. A new file gets the
/// permissions the umask leaves, a replaced one keeps those it had; one that may not be written is
/// not replaced. Pipes and character devices, and the names of open descriptors such as
/// /dev/stdout, cannot be replaced and are written to as they are.
///
/// Everything throws std::system_error naming the target, directories included.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  /// To the disk, then under its name. Nothing may be written after it.
  void commit();

 private:
  void open_temporary();
  [[noreturn]] void fail() const;

  std::filesystem::path path_;       // as given, for messages
  std::filesystem::path target_;     // what path_ points to
  std::filesystem::path temporary_;  // empty: written directly, or committed
  int descriptor_ = -1;
};

/// The same in one go.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

}  // namespace raybundle::io
