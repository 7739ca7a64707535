#include "io/field_mark.hpp"

#include <algorithm>
#include <fstream>
#include <string_view>
#include <utility>

#include "io/output_file.hpp"
#include "viscobar/io/io_error.hpp"

namespace viscobar {

namespace {

// What lies between and behind the values, in the order of the file.
std::vector<FieldMark::Region> gaps(const FieldMark& mark) {
  std::vector<FieldMark::Region> values = mark.values, between;
  std::ranges::sort(values, {}, &FieldMark::Region::begin);
  values.push_back({mark.length, 0});
  std::size_t at = 0;
  for (const FieldMark::Region& region : values) {
    if (region.begin > at) between.push_back({at, region.begin - at});
    at = region.begin + region.length;
  }
  return between;
}

}  // namespace

FieldMark marked(const std::filesystem::path& file, std::size_t rows, std::vector<FieldMark::Region> values) {
  OutputFile(file, OutputFile::Content::keep).sync();
  FieldMark mark{rows, std::filesystem::file_size(file), std::move(values), {}};
  std::ifstream stream(file, std::ios::binary);
  for (const FieldMark::Region& gap : gaps(mark)) {
    const std::size_t before = mark.others.size();
    mark.others.resize(before + gap.length);
    stream.seekg(static_cast<std::streamoff>(gap.begin));
    stream.read(mark.others.data() + before, static_cast<std::streamsize>(gap.length));
  }
  if (!stream) throw IoError(file, "cannot be read back");
  return mark;
}

void put_back(const std::filesystem::path& file, const FieldMark& mark) {
  OutputFile raw(file, OutputFile::Content::keep);
  raw.cut_at(mark.length);
  std::string_view others = mark.others;
  for (const FieldMark::Region& gap : gaps(mark)) {
    raw.write_at(gap.begin, others.substr(0, gap.length));
    others.remove_prefix(gap.length);
  }
  raw.sync();
  raw.close();
}

}  // namespace viscobar
