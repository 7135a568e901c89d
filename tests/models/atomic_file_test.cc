// A file appears whole or not at all, whatever goes wrong, and links, pipes and devices stay what
// they are.

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>

#include <gtest/gtest.h>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/tests/support/bal_check.h>
#include <raybundle/tests/support/random_problem.h>
#include <raybundle/tests/support/temporary_folder.h>

namespace raybundle::io {
namespace {

namespace fs = std::filesystem;
using test::read_text;
using test::TemporaryFolder;
using test::write_text;

mode_t permissions(const fs::path& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0);
  return status.st_mode & 0777U;
}

std::string message_of_writing(const fs::path& path) {
  try {
    write_file_atomically(path, "new");
  } catch (const std::system_error& error) {
    return error.what();
  }
  return "";
}

/// Makes writing beyond `bytes` into a file fail while it lives, as on a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST(AtomicFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "first");
  EXPECT_EQ(read_text(folder / "a"), "first");
  write_file_atomically(folder / "a", "");
  EXPECT_EQ(read_text(folder / "a"), "");
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(AtomicFile, NothingChangesWithoutCommit) {
  const TemporaryFolder folder;
  write_text(folder / "old", "old");
  {
    AtomicFile old_file(folder / "old");
    AtomicFile new_file(folder / "new");
    old_file.write("half");
    new_file.write("half");
    EXPECT_EQ(read_text(folder / "old"), "old");
    EXPECT_FALSE(fs::exists(folder / "new"));
  }
  EXPECT_EQ(read_text(folder / "old"), "old");
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(AtomicFile, AFullDiskLeavesThePreviousFile) {
  const TemporaryFolder folder;
  const Problem problem = test::random_problem(1, 20, 5000, 20000);
  write_text(folder / "out.txt", "previous");
  std::string message;
  {
    const FileSizeLimit limit(200'000);
    try {
      write_bal(problem, folder / "out.txt");
    } catch (const std::system_error& error) {
      message = error.what();
      EXPECT_EQ(error.code(), std::errc::file_too_large);
    }
  }
  EXPECT_EQ(message.find((folder / "out.txt").string() + ": cannot be written: "), 0U) << message;
  EXPECT_EQ(read_text(folder / "out.txt"), "previous");
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(AtomicFile, KeepsPermissionsAndTheUmask) {
  const TemporaryFolder folder;
  const mode_t before = ::umask(027);
  write_file_atomically(folder / "new", "x");
  write_text(folder / "old", "x");
  fs::permissions(folder / "old", fs::perms{0604});
  write_file_atomically(folder / "old", "y");
  ::umask(before);
  EXPECT_EQ(permissions(folder / "new"), 0640U);
  EXPECT_EQ(permissions(folder / "old"), 0604U);
}

TEST(AtomicFile, LinksStayLinks) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "sub");
  write_text(folder / "sub/file", "old");
  fs::create_symlink("sub/file", folder / "inner");
  fs::create_symlink(folder / "inner", folder / "outer");
  fs::create_symlink("sub/absent", folder / "dangling");
  write_file_atomically(folder / "outer", "new");
  write_file_atomically(folder / "dangling", "made");
  EXPECT_TRUE(fs::is_symlink(folder / "outer"));
  EXPECT_TRUE(fs::is_symlink(folder / "inner"));
  EXPECT_TRUE(fs::is_symlink(folder / "dangling"));
  EXPECT_EQ(read_text(folder / "sub/file"), "new");
  EXPECT_EQ(read_text(folder / "sub/absent"), "made");
}

TEST(AtomicFile, RefusesWhatIsNoFile) {
  const TemporaryFolder folder;
  fs::create_symlink("loop", folder / "loop");
  EXPECT_NE(message_of_writing(folder.path()).find("Is a directory"), std::string::npos);
  EXPECT_NE(message_of_writing(folder / "no/such").find("No such file"), std::string::npos);
  EXPECT_NE(message_of_writing(folder / "nothing/").find("No such file"), std::string::npos);
  EXPECT_NE(message_of_writing(folder / "loop").find("symbolic links"), std::string::npos);
  EXPECT_NE(message_of_writing("").find("No such file"), std::string::npos);
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(AtomicFile, RefusesAFileThatMayNotBeWritten) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everything";
  const TemporaryFolder folder;
  write_text(folder / "kept", "old");
  fs::permissions(folder / "kept", fs::perms{0444});
  EXPECT_NE(message_of_writing(folder / "kept").find("Permission denied"), std::string::npos);
  EXPECT_EQ(read_text(folder / "kept"), "old");
}

TEST(AtomicFile, LongNamesAreFine) {
  const TemporaryFolder folder;
  const std::string name(255, 'n');
  write_file_atomically(folder / name, "x");
  EXPECT_EQ(read_text(folder / name), "x");
}

TEST(AtomicFile, WritesIntoPipesAndReadsFromThem) {
  const TemporaryFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const Problem problem = test::random_problem(1, 20, 5000, 20000);  // more than a pipe holds
  std::thread writer([&] { write_bal(problem, pipe); });
  const Problem read = read_bal(pipe);
  writer.join();
  EXPECT_TRUE(test::same_bits(read, problem));
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(AtomicFile, WritesToDevicesDirectly) {
  EXPECT_NO_THROW(write_file_atomically("/dev/null", "x"));
  if (fs::exists("/dev/full")) {
    EXPECT_NE(message_of_writing("/dev/full").find("No space left"), std::string::npos);
  }
}

TEST(AtomicFile, NamesOfDescriptorsMeanThem) {
  // Standard output may be a file that others append to: it must not be replaced.
  const TemporaryFolder folder;
  write_text(folder / "log", "before ");
  const int descriptor = ::open((folder / "log").c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  write_file_atomically("/dev/fd/" + std::to_string(descriptor), "between ");
  EXPECT_EQ(::write(descriptor, "after", 5), 5);
  ::close(descriptor);
  EXPECT_EQ(read_text(folder / "log"), "before between after");
}

TEST(FileContent, ReadsFilesWithoutASizeAndFromTheMiddle) {
  if (fs::exists("/proc/self/status")) {
    EXPECT_NE(FileContent("/proc/self/status").text().find("Pid:"), std::string_view::npos);
  }
  const TemporaryFolder folder;
  write_text(folder / "file", "head tail");
  const int descriptor = ::open((folder / "file").c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  EXPECT_EQ(FileContent(descriptor, "file").text(), "head tail");
  ::lseek(descriptor, 5, SEEK_SET);
  EXPECT_EQ(FileContent(descriptor, "file").text(), "tail");
  ::close(descriptor);
}

}  // namespace
}  // namespace raybundle::io
