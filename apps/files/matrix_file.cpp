#include "apps/files/matrix_file.hpp"

#include <fmt/format.h>
#include <zip.h>

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "apps/files/csv_file.hpp"
#include "apps/shell/choice.hpp"

namespace axode::command {

namespace {

/// A line of CSV: the words with commas between them, and the end of the line.
std::string line_of(const std::vector<std::string>& words) {
  return fmt::format("{}\n", fmt::join(words, ","));
}
std::vector<std::string> all_quoted(const std::vector<std::string>& words) {
  std::vector<std::string> all;
  for (const std::string& word : words) all.push_back(quoted(word));
  return all;
}
void append_row(std::vector<std::string>& words, const Eigen::MatrixXd& matrix, Eigen::Index i) {
  for (Eigen::Index k = 0; k < matrix.cols(); ++k) words.push_back(fmt::format("{}", matrix(i, k)));
}

}  // namespace

FileFormat file_format(const std::string& file, const char* option) {
  static constexpr std::array<std::pair<std::string_view, FileFormat>, 3> endings{
      {{".json", FileFormat::json}, {".csv", FileFormat::csv}, {".npz", FileFormat::npz}}};
  return choose(std::string(option) + ": " + file + ": the ending",
                std::filesystem::path(file).extension().string(), endings);
}

std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& rows,
                   const std::vector<std::string>& columns) {
  std::vector<std::string> headings{""};
  headings.insert(headings.end(), columns.begin(), columns.end());
  std::string out = line_of(all_quoted(headings));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    std::vector<std::string> words{quoted(rows[static_cast<std::size_t>(i)])};
    append_row(words, matrix, i);
    out += line_of(words);
  }
  return out;
}

std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& columns) {
  std::string out = line_of(all_quoted(columns));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    std::vector<std::string> words;
    append_row(words, matrix, i);
    out += line_of(words);
  }
  return out;
}

namespace {

/// The bytes of an .npy file (format 1.0).
std::string as_npy(const NamedArray& array) {
  const Eigen::MatrixXd& matrix = array.numbers;
  constexpr std::size_t before_header = 10, line = 64;  // numbers begin at a multiple of 64 bytes
  const std::string columns = array.is_vector ? "" : fmt::format(" {}", matrix.cols());
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},{}), }}", matrix.rows(), columns);
  header.append(line - 1 - (before_header + header.size()) % line, ' ');
  header += '\n';
  std::string out("\x93NUMPY\x01\x00", 8);
  const auto append = [&](std::uint64_t number, int bytes) {
    for (int k = 0; k < bytes; ++k) out += static_cast<char>(number >> (8 * k) & 0xFF);
  };
  append(header.size(), 2);
  out += header;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) append(std::bit_cast<std::uint64_t>(matrix(i, k)), 8);
  return out;
}

/// Throws if a call of libzip has returned null, because there is no memory.
template <class T> T* made(T* thing) {
  if (thing == nullptr) throw std::runtime_error("no .npz can be written: there is not enough memory");
  return thing;
}

}  // namespace

std::string as_npz(const std::vector<NamedArray>& arrays) {
  const std::unique_ptr<zip_source_t, void (*)(zip_source_t*)> bytes(
      made(zip_source_buffer_create(nullptr, 0, 0, nullptr)), zip_source_free);
  zip_source_keep(bytes.get());  // otherwise the archive would free the source
  std::unique_ptr<zip_t, void (*)(zip_t*)> archive(
      made(zip_open_from_source(bytes.get(), ZIP_TRUNCATE, nullptr)), zip_discard);
  std::vector<std::string> files;
  for (const NamedArray& array : arrays) files.push_back(as_npy(array));
  for (std::size_t k = 0; k < files.size(); ++k) {
    zip_source_t* file = made(zip_source_buffer(archive.get(), files[k].data(), files[k].size(), 0));
    const zip_int64_t index =
        zip_file_add(archive.get(), (arrays[k].name + ".npy").c_str(), file, ZIP_FL_ENC_UTF_8);
    made(index < 0 ? nullptr : file);
    zip_set_file_compression(archive.get(), static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0);
    zip_file_set_dostime(archive.get(), static_cast<zip_uint64_t>(index), 0, 0x21,
                         0);  // the time is 1980, so that the bytes are the same in every run
  }
  made(zip_close(archive.get()) == 0 ? archive.release() : nullptr);
  zip_stat_t size;
  zip_stat_init(&size);
  std::string out;
  if (zip_source_stat(bytes.get(), &size) == 0 && zip_source_open(bytes.get()) == 0) {
    out.resize(size.size);
    const zip_int64_t read = zip_source_read(bytes.get(), out.data(), out.size());
    zip_source_close(bytes.get());
    made(read == static_cast<zip_int64_t>(out.size()) ? bytes.get() : nullptr);
  }
  return out;
}

}  // namespace axode::command
