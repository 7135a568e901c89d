#include <raybundle/tools/output.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include <raybundle/models/io/atomic_file.h>

namespace raybundle::tools {

void check_output(const std::string& output) {
  const std::string path = output_path(output);
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISFIFO(status.st_mode) && output != "-") {
    // Opening it would wait for a reader, and closing it again would end what that one reads.
    if (::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) == 0) return;
    throw std::system_error(errno, std::generic_category(), path + ": cannot be written");
  }
  const io::AtomicFile probe(path);
}

std::string output_path(const std::string& output) {
  return output == "-" ? "/dev/stdout" : output;
}

void print(std::string_view text) {
  try {
    io::write_file_atomically(output_path("-"), text);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::broken_pipe) throw;
  }
}

}  // namespace raybundle::tools
