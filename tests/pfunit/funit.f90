! SPDX-License-Identifier: BSD-3-Clause
!> What a serial .pf file uses.
module funit
  use funit_assertions, only: assertFail, assertFalse, assertGreaterThan, assertGreaterThanOrEqual, assertIsFinite, &
    assertIsNaN, assertLessThan, assertLessThanOrEqual, assertTrue
  use funit_equality, only: assertEqual, assertNotEqual, assertRelativelyEqual
  use funit_exceptions, only: SourceLocation, anyExceptions
  implicit none(type, external)
  public
end module funit
