#include "apps/fmu/zip_archive.hpp"

#include <zip.h>

#include <memory>
#include <stdexcept>

namespace axode::command {
namespace {

/// Returns a pointer that libzip made. Throws std::runtime_error if it is null, for lack of memory.
template <class T> T* made(T* thing) {
  if (thing == nullptr) throw std::runtime_error("no archive can be written: there is not enough memory");
  return thing;
}

}  // namespace

std::string as_zip(const std::vector<std::pair<std::string, std::string>>& files, Compression compression) {
  const std::unique_ptr<zip_source_t, void (*)(zip_source_t*)> bytes(
      made(zip_source_buffer_create(nullptr, 0, 0, nullptr)), zip_source_free);
  zip_source_keep(bytes.get());  // otherwise the archive would free the source
  std::unique_ptr<zip_t, void (*)(zip_t*)> archive(
      made(zip_open_from_source(bytes.get(), ZIP_TRUNCATE, nullptr)), zip_discard);
  const zip_int32_t method = compression == Compression::stored ? ZIP_CM_STORE : ZIP_CM_DEFLATE;
  for (const auto& [name, contents] : files) {
    zip_source_t* file = made(zip_source_buffer(archive.get(), contents.data(), contents.size(), 0));
    const zip_int64_t index = zip_file_add(archive.get(), name.c_str(), file, ZIP_FL_ENC_UTF_8);
    made(index < 0 ? nullptr : file);
    zip_set_file_compression(archive.get(), static_cast<zip_uint64_t>(index), method, 0);
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
