#pragma once
#include <cstddef>
#include <cstdint>

/// Declarations from the interface by which XLA, the compiler of JAX, calls functions: the structs that this
/// library needs. They repeat the published C interface xla/ffi/api/c_api.h, so that no jaxlib is needed to
/// compile them; a test compares them member by member.
namespace axode::xla {

inline constexpr int major_version = 0, minor_version = 3;  ///< version of the interface that this file
                                                            ///< describes
inline constexpr int first_minor_version = 1;               ///< first minor version that has all of these
                                                            ///< structs

/// The beginning of every struct of the interface.
struct Sized {
  std::size_t struct_size;
  void* extensions;
};

struct Version {
  Sized sized;
  int major, minor;
};

enum class ErrorCode : std::int32_t { invalid_argument = 3, internal = 13 };
struct Error;  ///< defined by XLA
struct NewError {
  Sized sized;
  const char* message;
  ErrorCode code;
};

/// The table of XLA's own functions, one of which makes errors.
struct Api {
  Sized sized;
  Version version;
  const void* internal;
  Error* (*new_error)(NewError*);
};

enum class Type : std::int32_t { boolean = 1, int64 = 5, float32 = 11, float64 = 12 };
/// An array of an argument or a result, stored row by row.
struct Buffer {
  Sized sized;
  Type type;
  void* data;
  std::int64_t rank;
  std::int64_t* lengths;
};

enum class AttributeKind : std::int32_t { array = 1, dictionary, scalar, text };
struct Text {
  const char* data;
  std::size_t size;
};
struct Scalar {
  Type type;
  void* value;
};

struct Buffers {
  Sized sized;
  std::int64_t size;
  std::int32_t* kinds;
  Buffer** all;
};
struct Attributes {
  Sized sized;
  std::int64_t size;
  AttributeKind* kinds;
  Text** names;
  void** values;
};

enum class Stage : std::int32_t { instantiate, prepare, initialize, execute };
struct CallFrame {
  Sized sized;
  const Api* api;
  void* context;
  Stage stage;
  Buffers arguments, results;
  Attributes attributes;
};

/// The structs of a call that only asks for the version; its `extensions` points to a MetadataRequest.
struct Metadata {
  std::size_t struct_size;
  Version version;
  std::uint32_t traits;
};
struct MetadataRequest {
  static constexpr std::int32_t expected = 1;
  std::size_t struct_size;
  std::int32_t kind;
  void* next;
  Metadata* metadata;
};

using Handler = Error*(CallFrame*);

}  // namespace axode::xla
