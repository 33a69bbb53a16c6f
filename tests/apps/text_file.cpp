#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>

#include "tests/apps/run_command.hpp"

/// Files that the command writes are replaced as a whole; if writing fails, the old file stays.
namespace axode::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Outcome in_shell(const std::string& line) {
  return run({"/bin/sh", "-c", line, AXODE_COMMAND, robot("arm7.toml")});
}

std::size_t files_in(const TemporaryFolder& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
}

mode_t mode_of(const std::string& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) throw std::runtime_error("no file " + file);
  return status.st_mode & 07777;
}

TEST(WrittenFile, IsAsItWasAfterAFailureThoughItIsTheInput) {
  const TemporaryFolder folder;
  const std::string text = contents(robot("arm7.toml")), file = folder.write("arm.toml", text);
  // The limit is one block of 512 or 1024 bytes, so that the disk is full in the middle of the text.
  const Outcome outcome = in_shell("ulimit -f 1; exec \"$0\" convert --force '" + file + "' '" + file + "'");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err, "axode convert: " + file + ": the file cannot be written: File too large\n");
  EXPECT_EQ(contents(file), text);
  EXPECT_EQ(files_in(folder), 1U);
}

TEST(WrittenFile, IsAsItWasIfASignalEndsTheCommand) {
  const TemporaryFolder folder;
  const std::string file = folder.write("arm.c", "precious");
  const pid_t child = fork();
  if (child ==
      0) {  // The signal is pending and blocked when the command starts, so that it arrives while the command
            // writes.
    sigset_t signal;
    sigemptyset(&signal), sigaddset(&signal, SIGTERM);
    sigprocmask(SIG_BLOCK, &signal, nullptr);
    raise(SIGTERM);
    if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
    detail::become({AXODE_COMMAND, "codegen", robot("double_pendulum.toml"), "--output", file});
  }
  EXPECT_EQ(detail::exit_code_of(child), 1);
  EXPECT_EQ(contents(file), "precious");
  EXPECT_EQ(files_in(folder), 1U);
}

TEST(WrittenFile, KeepsPermissionsAndSymbolicLinks) {
  const TemporaryFolder folder;
  const std::string target = folder.write("target.toml", "old"), link = folder.file("link.toml"),
                    dangling = folder.file("dangling.toml"), made = folder.file("made.toml");
  ASSERT_EQ(chmod(target.c_str(), 0604), 0);
  std::filesystem::create_symlink("target.toml", link);
  std::filesystem::create_symlink("made.toml", dangling);
  const Outcome outcome = in_shell("umask 027; \"$0\" convert --force \"$1\" '" + link +
                                   "' && \"$0\" convert \"$1\" '" + dangling + "'");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_TRUE(std::filesystem::is_symlink(dangling));
  EXPECT_THAT(contents(target), HasSubstr("axode drawing"));
  EXPECT_EQ(contents(made), contents(target));
  EXPECT_EQ(mode_of(target), 0604U);
  EXPECT_EQ(mode_of(made), 0640U);
  EXPECT_EQ(files_in(folder), 4U);
}

TEST(WrittenFile, MayBeADeviceAPipeOrAnOpenFile) {
  const TemporaryFolder folder;
  const std::string text = axode({"codegen", robot("arm7.toml")}).out, open = folder.write("open.c", ""),
                    other = folder.file("other.c");
  std::filesystem::create_hard_link(open, other);
  const Outcome full = in_shell("\"$0\" codegen \"$1\" --output /dev/full");
  EXPECT_EQ(full.code, 1);
  EXPECT_EQ(full.err, "axode codegen: /dev/full: the file cannot be written: No space left on device\n");
  EXPECT_THAT(in_shell("\"$0\" codegen \"$1\" --output /dev/stdout | cat").out, StartsWith(text));
  EXPECT_EQ(in_shell("\"$0\" codegen \"$1\" --output /dev/stdout > '" + open + "'").code, 0);
  EXPECT_EQ(contents(other), text);  // the same file was written, not a new one in
                                     // its place
  EXPECT_EQ(files_in(folder), 2U);
}

}  // namespace
}  // namespace axode::test
