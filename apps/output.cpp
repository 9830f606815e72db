#include "apps/output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <system_error>

namespace atrium {
namespace {

Status write_failed(const std::string& path, const std::string& why) {
  return Status(Code::kStore, path, "", "could not be written: " + why,
                "see that its folder exists and its disk has room");
}

using Parts = std::initializer_list<std::string_view>;

Status write_file(const std::string& path, Parts parts) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return write_failed(path, std::strerror(errno));
  bool written = true;
  for (const std::string_view p : parts)
    written = written && std::fwrite(p.data(), 1, p.size(), file) == p.size();
  const int error = errno;
  if (std::fclose(file) != 0) return write_failed(path, std::strerror(errno));
  return written ? Status() : write_failed(path, std::strerror(error));
}

}  // namespace

Status write_output(const std::string& path, std::initializer_list<std::string_view> parts) {
  if (path.empty() || path == "-") {
    for (const std::string_view p : parts)
      std::cout.write(p.data(), static_cast<std::streamsize>(p.size()));
    return {};  // a stdout that fails is told at the end
  }
  std::error_code ignored;
  const auto kind = std::filesystem::status(path, ignored).type();
  if (kind == std::filesystem::file_type::directory) return write_failed(path, "it is a folder");
  const bool plain =
      kind == std::filesystem::file_type::regular || kind == std::filesystem::file_type::not_found;
  if (!plain) return write_file(path, parts);  // a pipe or a device
  const std::string part = path + ".part";
  Status status = write_file(part, parts);
  if (status.ok() && std::rename(part.c_str(), path.c_str()) != 0)
    status = write_failed(path, std::strerror(errno));
  if (!status.ok()) std::remove(part.c_str());
  return status;
}

Result<std::string> read_input(const std::string& path) {
  if (path == "-")
    return std::string(std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>());
  std::error_code ignored;
  std::ifstream in(path, std::ios::binary);
  if (std::filesystem::is_directory(path, ignored) || !in)
    return Status(Code::kUsage, path, "", "could not be read", "name a file that exists");
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad())
    return Status(Code::kUsage, path, "", "could not be read to its end", "see to its disk");
  return text;
}

}  // namespace atrium
