#include "common/linear_algebra/preconditioner_age.h"

#include <gtest/gtest.h>

using heartbus::fem::PreconditionerAge;

TEST(PreconditionerAge, OneIsDueWhereThereIsNoneOrItServesHalfAsWell) {
  PreconditionerAge age(3);
  EXPECT_TRUE(age.is_due());
  age.renew();
  EXPECT_FALSE(age.is_due());
  age.note(0); // nothing to solve says nothing
  age.note(10);
  EXPECT_EQ(age.usual(), 10u);
  age.note(18); // 10 + 5 + 3
  EXPECT_FALSE(age.is_due());
  age.note(19);
  EXPECT_TRUE(age.is_due());
  age.renew();
  EXPECT_FALSE(age.is_due());
  age.note(30);
  EXPECT_EQ(age.usual(), 30u);
  age.forget();
  EXPECT_TRUE(age.is_due());
}
