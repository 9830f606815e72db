#include "apps/report/data_uri.h"

#include <gtest/gtest.h>

namespace atrium {
namespace {

// RFC 4648 §10.
TEST(DataUri, HasTheBytesInBase64) {
  EXPECT_EQ(data_uri("text/plain", ""), "data:text/plain;base64,");
  EXPECT_EQ(data_uri("text/plain", "f"), "data:text/plain;base64,Zg==");
  EXPECT_EQ(data_uri("text/plain", "fo"), "data:text/plain;base64,Zm8=");
  EXPECT_EQ(data_uri("text/plain", "foo"), "data:text/plain;base64,Zm9v");
  EXPECT_EQ(data_uri("text/plain", "foob"), "data:text/plain;base64,Zm9vYg==");
  EXPECT_EQ(data_uri("text/plain", "foobar"), "data:text/plain;base64,Zm9vYmFy");
  EXPECT_EQ(data_uri("image/png", "\xFF\xFE"), "data:image/png;base64,//4=") << "bytes above 127";
}

}  // namespace
}  // namespace atrium
