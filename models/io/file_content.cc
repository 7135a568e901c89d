#include <raybundle/models/io/file_content.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include <raybundle/models/error.h>

namespace raybundle::io {
namespace {

constexpr const char* readable = "a file that can be read";

std::string words(int error) {
  return "nothing readable (" + std::generic_category().message(error) + ")";
}

std::string read_to_end(int descriptor, const std::string& source) {
  constexpr std::size_t piece = std::size_t{1} << 20;
  const auto most = static_cast<std::size_t>(largest_stream());
  std::string text;
  std::size_t size = 0;
  while (true) {
    // Only as much as comes is kept, whatever the stream may promise.
    if (text.size() - size < piece) text.resize(2 * text.size() + piece);
    const ssize_t count = ::read(descriptor, text.data() + size, text.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw InputError(source, 0, words(errno), readable);
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
    if (size > most) {
      throw InputError(source, 0, "a stream that does not end",
                       "at most " + std::to_string(most) + " bytes");
    }
  }
  text.resize(size);
  return text;
}

}  // namespace

FileContent::FileContent(const std::filesystem::path& path) {
  const std::string source = path.string();
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY);
  if (descriptor < 0) throw InputError(source, 0, words(errno), readable);
  try {
    load(descriptor, source);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  ::close(descriptor);
}

FileContent::FileContent(int descriptor, const std::string& source) { load(descriptor, source); }

FileContent::~FileContent() {
  if (mapping_ != nullptr) ::munmap(mapping_, text_.size());
}

void FileContent::load(int descriptor, const std::string& source) {
  if (map(descriptor)) return;
  copy_ = read_to_end(descriptor, source);
  text_ = copy_;
}

bool FileContent::map(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return false;
  // Files of /proc say 0 and have content; a descriptor may have been read in part.
  if (status.st_size == 0 || ::lseek(descriptor, 0, SEEK_CUR) != 0) return false;
  const auto size = static_cast<std::size_t>(status.st_size);
  void* mapping = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (mapping == MAP_FAILED) return false;
  ::madvise(mapping, size, MADV_SEQUENTIAL);
  mapping_ = mapping;
  text_ = std::string_view(static_cast<const char*>(mapping), size);
  return true;
}

std::int64_t largest_stream() {
  const std::int64_t pages = ::sysconf(_SC_PHYS_PAGES);
  const std::int64_t page_size = ::sysconf(_SC_PAGESIZE);
  constexpr std::int64_t fallback = std::int64_t{1} << 32;
  return pages > 0 && page_size > 0 ? pages / 2 * page_size : fallback;
}

}  // namespace raybundle::io
