#include <raybundle/models/io/atomic_file.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <string>
#include <system_error>

namespace raybundle::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_error(int error, const fs::path& path) {
  throw std::system_error(error, std::generic_category(), path.string() + ": cannot be written");
}

/// The descriptor that names such as /dev/stdout or /dev/fd/7 stand for; -1 for other names.
int named_descriptor(const fs::path& path) {
  const std::string name = path.lexically_normal().string();
  if (name == "/dev/stdout") return STDOUT_FILENO;
  if (name == "/dev/stderr") return STDERR_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!name.starts_with(folder)) continue;
    int descriptor = -1;
    const char* last = name.data() + name.size();
    const auto result = std::from_chars(name.data() + folder.size(), last, descriptor);
    if (result.ec == std::errc() && result.ptr == last) return descriptor;
  }
  return -1;
}

/// What a chain of links ends at, which need not exist.
fs::path resolve_links(fs::path path) {
  constexpr int most_links = 40;  // as the kernel allows
  for (int i = 0; i < most_links; ++i) {
    std::error_code error;
    if (!fs::is_symlink(fs::symlink_status(path, error))) return path;
    path = path.parent_path() / fs::read_symlink(path);
  }
  throw_error(ELOOP, path);
}

/// A name beside `target` that no other writer of this or another process uses.
fs::path temporary_name(const fs::path& target) {
  static std::atomic<std::uint64_t> count{0};
  constexpr std::size_t longest_stem = 180;  // leaves room below the usual limit of 255
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  return target.parent_path() / ("." + target.filename().string().substr(0, longest_stem) + "." +
                                 std::to_string(::getpid()) + "-" + std::to_string(now) + "-" +
                                 std::to_string(count++) + ".tmp");
}

/// Makes the new name last. Some file systems cannot, and some folders may not be opened: then the
/// file is there all the same.
void sync_folder(const fs::path& folder) {
  const fs::path name = folder.empty() ? fs::path(".") : folder;
  const int descriptor = ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  const int error = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  if (error == EIO) throw_error(error, folder);
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& path) : path_(path) {
  if (const int named = named_descriptor(path); named >= 0) {
    descriptor_ = ::fcntl(named, F_DUPFD_CLOEXEC, 0);
    if (descriptor_ < 0) fail();
    return;
  }
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) fail();
  if (exists && S_ISDIR(status.st_mode)) throw_error(EISDIR, path_);
  if (exists && (S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode))) {
    descriptor_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor_ < 0) fail();
    return;
  }
  if (exists && !S_ISREG(status.st_mode)) throw_error(EINVAL, path_);
  if (exists && ::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) != 0) fail();

  target_ = resolve_links(path);
  if (!target_.has_filename()) throw_error(ENOENT, path_);
  open_temporary();
  constexpr mode_t permissions = 0777;
  if (exists && ::fchmod(descriptor_, status.st_mode & permissions) != 0) {
    const int error = errno;
    ::close(descriptor_);
    ::unlink(temporary_.c_str());
    throw_error(error, path_);
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::open_temporary() {
  do {
    temporary_ = temporary_name(target_);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) fail();
}

void AtomicFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void AtomicFile::commit() {
  const bool direct = temporary_.empty();
  if (!direct && ::fsync(descriptor_) != 0) fail();
  const int descriptor = descriptor_;
  descriptor_ = -1;
  if (::close(descriptor) != 0) fail();
  if (direct) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail();
  temporary_.clear();
  sync_folder(target_.parent_path());
}

void AtomicFile::fail() const { throw_error(errno, path_); }

void write_file_atomically(const fs::path& path, std::string_view content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace raybundle::io
