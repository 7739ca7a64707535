#include "results/field/field_mark.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string_view>
#include <utility>

#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

/// Visits the file in its order: a gap (of length 0 where there is none), the region behind it, and so on; behind the
/// last gap comes a region of length 0.
template <class Visit>
void for_each_part(const FieldMark& mark, Visit&& visit) {
  std::vector<FieldMark::Region> regions = mark.regions;
  std::ranges::sort(regions, {}, &FieldMark::Region::begin);
  regions.push_back({mark.length, 0, {}});
  std::size_t at = 0;
  for (const FieldMark::Region& region : regions) {
    visit(at, region.begin - at, region);
    at = region.begin + region.length;
  }
}

}  // namespace

Checksum FieldMark::checksum() const {
  Checksum whole;
  std::string_view rest = others;
  for_each_part(*this, [&](std::size_t, std::size_t gap, const Region& region) {
    whole.add(rest.substr(0, gap));
    rest.remove_prefix(gap);
    whole.append(region.values);
    whole.append(Checksum::of_zeros(region.length - region.values.bytes));
  });
  return whole;
}

void FieldMark::check_values(const std::filesystem::path& file) const {
  for (const Region& region : regions)
    if (checksum_of_file(file, region.begin, region.values.bytes) != region.values)
      throw IoError(file,
                    fmt::format("its bytes {} to {} are not those of the checkpoint: it was changed or damaged since",
                                region.begin, region.begin + region.values.bytes));
}

FieldMark marked(const std::filesystem::path& file, std::size_t rows, std::vector<FieldMark::Region> regions) {
  FieldMark mark{rows, std::filesystem::file_size(file), std::move(regions), {}};
  std::ifstream stream(file, std::ios::binary);
  for_each_part(mark, [&](std::size_t gap, std::size_t length, const FieldMark::Region&) {
    const std::size_t before = mark.others.size();
    mark.others.resize(before + length);
    stream.seekg(static_cast<std::streamoff>(gap));
    stream.read(mark.others.data() + before, static_cast<std::streamsize>(length));
  });
  if (!stream) throw IoError(file, "cannot be read back");
  return mark;
}

void put_back(const std::filesystem::path& file, const FieldMark& mark) {
  OutputFile raw(file, OutputFile::Content::keep);
  raw.cut_at(mark.length);
  std::string_view others = mark.others;
  for_each_part(mark, [&](std::size_t gap, std::size_t length, const FieldMark::Region& region) {
    raw.write_at(gap, others.substr(0, length));
    others.remove_prefix(length);
    // Values that came later.
    raw.write_at(region.begin + region.values.bytes, std::string(region.length - region.values.bytes, '\0'));
  });
  raw.sync();
  raw.close();
}

}  // namespace viscobar
