#include <raybundle/tools/output.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/solver/option_table.h>

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

bool same_file(const std::string& a, const std::string& b) {
  if (a == "-" || b == "-") return a == b;
  std::error_code ignored;
  if (std::filesystem::equivalent(a, b, ignored)) return true;  // links too
  const auto place = [](const std::string& path) {
    std::error_code none;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path, none), none);
  };
  return place(a) == place(b);
}

bool names_folder(const std::string& output) {
  return output.ends_with('/') || std::filesystem::is_directory(output);
}

void check_folder(const std::string& option, const std::string& output, const std::string& input) {
  if (!input.empty() && same_file(output, input)) {
    throw OptionError(option + " is the input, which is never changed: " + output);
  }
  const std::filesystem::path folder = std::filesystem::path(output) / "";
  const std::filesystem::path name = folder.parent_path();  // without the slash
  if (!std::filesystem::exists(name)) return check_output(name.string());
  if (!std::filesystem::is_directory(name)) {
    throw OptionError(option + ": " + output + " is a file; ParallaxBA's format is a folder");
  }
  if (io::holds_parallaxba(name)) {
    throw OptionError(option + ": " + output + " holds a problem already; name another folder");
  }
  check_output((folder / "Cam.txt").string());
}

void check_apart(const std::string& output, const std::string& log) {
  if (output.empty() || log.empty() || !same_file(output, log)) return;
  throw OptionError("--output and --log are the same: " + log);
}

void check_result(const std::string& option, const std::string& output, const std::string& input) {
  if (output.empty()) return;
  if (!input.empty() && input != "-" && output != "-" && same_file(output, input)) {
    throw OptionError(option + " is the input, which is never changed: " + output);
  }
  if (io::is_parallaxba(input) && io::is_parallaxba_file(output) &&
      same_file(std::filesystem::absolute(output).parent_path(), input)) {
    throw OptionError(option + " would be a part of the input, which is never changed: " + output);
  }
  for (const char* ending : {".gz", ".bz2", ".xz", ".zst"}) {
    if (!output.ends_with(ending)) continue;
    throw OptionError(option + ": " + output + " would not be compressed; leave out the " + ending);
  }
  check_output(output);
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

void print_report(const std::string& report, bool standard_output_taken) {
  if (standard_output_taken) {
    std::fputs(report.c_str(), stderr);
  } else {
    print(report);
  }
}

std::string shown_name(const std::string& output) {
  return output == "-" ? "standard output" : output;
}

}  // namespace raybundle::tools
