! SPDX-License-Identifier: BSD-3-Clause
!> The linear problem of a step (sig_friction_unknowns) from factors of another one, in which few contacts had other states.
!>
!> A contact has one law for each of its rows, which is linear in y and z: a sum of y, as w_n = 0 where it is closed, or one of z
!> alone, as lambda_n = 0 where it is open. With factors of the problem P of other states, the laws of P may have any right-hand
!> sides r: Z_j are the z where r is 1 for the law of row j and 0 for all others, and cost a solution each. Where the laws of the
!> rows C differ, the problem J has the solution
!>
!>     z = P^-1 b + sum_C Z_j r_j,     law_i(z) = b_i for each row i in C,
!>
!> where what P^-1 takes for b in rows of C does not matter, because r makes up for it. r solves as many equations as there are such
!> rows. Z_j belongs to the law of P, and not to that of J: it serves all steps until P changes. Where other laws differ a little,
!> as those of directions that turn, this is P^-1 of an iteration (sig_friction_kept).
module sig_friction_exchange
  use sig_dense_kernels, only: add_few_columns, factor_lu, multiply_transpose, solve_lu
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_contacts_t, friction_unknown_t, &
    friction_workspace_t
  use sig_friction_unknowns, only: fill_independent, start_unknowns, sum_equations
  use sig_kinds, only: rk
  use sig_lcp_types, only: measure_pivots, trusted_pivots
  implicit none(type, external)
  private
  public :: choose_exchanged, prepare_exchange, divide

  !> [-] square of the change of a direction above which its laws are exchanged: 60 degrees
  real(rk), parameter :: far_turned = 1

contains

  !> Lists the rows whose laws in the workspace are others than those that are remembered.
  subroutine choose_exchanged(friction, contacts, workspace, is_exact)
    !> [-] f of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    !> whether the laws of all other rows are the same
    logical, intent(out) :: is_exact
    logical :: is_other, slides
    integer :: i, k

    is_exact = .true.
    associate (kept => workspace%kept, exchange => workspace%kept%exchange)
      exchange%n = 0
      do k = 1, contacts%n_contacts
        associate (old => kept%states(k), new => workspace%states(k))
          is_other = old /= new
          if (is_other .and. (old == contact_open .or. new == contact_open)) call add_row(1)
          if (.not. is_other .and. new == contact_slips) then
            associate (turned => workspace%directions(:, k) - kept%directions(:, k))
              is_other = dot_product(turned, turned) > far_turned .or. &
                ((workspace%softness(k) < huge(turned)) .neqv. (kept%softness(k) < huge(turned)))
              if (.not. is_other) is_exact = is_exact .and. all(abs(turned) <= 0) .and. &
                abs(workspace%softness(k) - kept%softness(k)) <= 0 .and. abs(friction(k) - kept%friction(k)) <= 0
            end associate
          end if
          ! with lambda_n = 0, lambda_t = f lambda_n d is lambda_t = 0
          slides = old == contact_slips .and. new == contact_open .and. contacts%n_tangents(k) == 1 .and. .not. kept%is_inverse
          if (.not. is_other .or. slides) cycle
          do i = 1, contacts%n_tangents(k)
            call add_row(1 + i)
          end do
        end associate
      end do
    end associate

  contains

    subroutine add_row(slot)
      integer, intent(in) :: slot

      associate (exchange => workspace%kept%exchange)
        exchange%n = exchange%n + 1
        if (exchange%n > size(exchange%contacts)) return
        exchange%contacts(exchange%n) = k
        exchange%slots(exchange%n) = slot
      end associate
    end subroutine add_row
  end subroutine choose_exchanged

  !> Sets up the equations of the rows whose laws differ. Requires: factors of P, choose_exchanged.
  subroutine prepare_exchange(square, friction, contacts, unknowns, workspace, is_usable)
    !> W or its inverse
    real(rk), contiguous, intent(in) :: square(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> of J
    type(friction_unknown_t), intent(in) :: unknowns(:)
    type(friction_workspace_t), intent(inout) :: workspace
    !> whether their matrix is far from singular
    logical, intent(out) :: is_usable
    real(rk) :: ratio
    integer :: i, info, j

    is_usable = .true.
    associate (kept => workspace%kept, exchange => workspace%kept%exchange)
      exchange%place_in_new(:size(square, 1)) = 0
      do j = 1, size(unknowns)
        exchange%place_in_new(unknowns(j)%home) = j
      end do
      if (exchange%n == 0) return
      do i = 1, exchange%n
        call take_law(friction, contacts, unknowns, workspace, i)
      end do
      call make_room(workspace)
      do i = 1, exchange%n
        call find_column(square, contacts, workspace, exchange%contacts(i), exchange%slots(i))
      end do
      do i = 1, exchange%n
        call find_images(square, contacts, exchange%laws(i), workspace)
      end do
      do j = 1, exchange%n
        do i = 1, exchange%n
          exchange%square(i, j) = law_of_column(i, exchange%column_of(exchange%laws(j)%home))
        end do
      end do
      call factor_lu(exchange%n, exchange%square, exchange%pivots, info)
      call measure_pivots(exchange%square, exchange%n, ratio)
      is_usable = info == 0 .and. ratio >= trusted_pivots
      kept%n_operations = kept%n_operations + 2 * real(exchange%n, rk)**3 / 3
    end associate

  contains

    !> Returns what the law of row i of C is for a column.
    pure real(rk) function law_of_column(i, column) result(sum_of_law)
      integer, intent(in) :: i, column
      integer :: a

      sum_of_law = 0
      associate (exchange => workspace%kept%exchange, law => workspace%kept%exchange%laws(i))
        do a = 1, law%n_rows
          if (abs(law%of_y(a)) > 0) &
            sum_of_law = sum_of_law + law%of_y(a) * exchange%images(exchange%image_of(law%rows(a)), column)
          sum_of_law = sum_of_law + law%of_z(a) * exchange%columns(law%rows(a), column)
        end do
      end associate
    end function law_of_column
  end subroutine prepare_exchange

  !> Sets the law of the i-th row of C: the equation of the unknown that has its home there, or what is known of z.
  pure subroutine take_law(friction, contacts, unknowns, workspace, i)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_unknown_t), intent(in) :: unknowns(:)
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: i

    associate (exchange => workspace%kept%exchange)
      associate (k => exchange%contacts(i), law => exchange%laws(i))
        law%n_rows = 1 + contacts%n_tangents(k)
        law%rows = [k, contacts%tangents(:, k)]
        law%home = law%rows(exchange%slots(i))
        if (exchange%place_in_new(law%home) > 0) then
          law%of_y = unknowns(exchange%place_in_new(law%home))%of_y
          law%of_z = unknowns(exchange%place_in_new(law%home))%of_z
        else
          law%of_y = 0
          law%of_z = known_law(exchange%slots(i), workspace%states(k), workspace%directions(:, k), friction(k), &
            workspace%kept%is_inverse) * size_of_row(k, exchange%slots(i), workspace)
        end if
      end associate
    end associate
  end subroutine take_law

  !> Returns the sum of z of a contact that is 0 in a row without an unknown.
  pure function known_law(slot, state, d, f, is_inverse) result(of_z)
    !> which one of the rows of the contact
    integer, intent(in) :: slot
    integer, intent(in) :: state
    real(rk), intent(in) :: d(2)
    real(rk), intent(in) :: f
    logical, intent(in) :: is_inverse
    real(rk) :: of_z(3)

    of_z = 0
    of_z(slot) = 1
    if (is_inverse .or. state /= contact_slips .or. slot == 1 .or. all(abs(d) <= 0)) return
    of_z = [-f, d]
    if (slot == 3) of_z = [0.0_rk, -d(2), d(1)]
  end function known_law

  !> Returns how large y is for z = 1, so that all laws have the same units.
  pure real(rk) function size_of_row(k, slot, workspace)
    integer, intent(in) :: k, slot
    type(friction_workspace_t), intent(in) :: workspace

    size_of_row = workspace%c(min(slot, 2), k)
    if (.not. workspace%kept%is_inverse) size_of_row = 1 / size_of_row
  end function size_of_row

  !> Drops all columns and images if the new ones would not fit beside them.
  pure subroutine make_room(workspace)
    type(friction_workspace_t), intent(inout) :: workspace
    integer :: i, n

    associate (exchange => workspace%kept%exchange)
      n = exchange%n_columns
      do i = 1, exchange%n
        if (exchange%column_of(exchange%laws(i)%home) == 0) n = n + 1
      end do
      if (n > size(exchange%columns, 2) .or. exchange%n_images + 3 * exchange%n > size(exchange%images, 1)) call exchange%clear()
    end associate
  end subroutine make_room

  !> Computes Z of a row of P, if it is not there yet.
  subroutine find_column(square, contacts, workspace, k, slot)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    !> contact, and which one of its rows
    integer, intent(in) :: k, slot
    real(rk) :: of_z(3)
    integer :: i, row

    row = k
    if (slot > 1) row = contacts%tangents(slot - 1, k)
    associate (kept => workspace%kept, exchange => workspace%kept%exchange, n => size(square, 1))
      if (exchange%column_of(row) > 0) return
      exchange%n_columns = exchange%n_columns + 1
      exchange%column_of(row) = exchange%n_columns
      associate (old => kept%unknowns(:kept%n), column => exchange%columns(:n, exchange%n_columns), x => workspace%work(:kept%n), &
        known => exchange%known(:n))
        ! rows behind those of the problem are added up, too
        exchange%columns(n + 1:, exchange%n_columns) = 0
        exchange%known(n + 1:) = 0
        known = 0
        if (kept%places(row) > 0) then
          x = 0
          x(kept%places(row)) = 1
        else
          of_z = known_law(slot, kept%states(k), kept%directions(:, k), kept%friction(k), kept%is_inverse) / &
            size_of_row(k, slot, workspace)
          if (slot == 1) known(k) = of_z(1)
          do i = 1, merge(contacts%n_tangents(k), 0, slot > 1)
            known(contacts%tangents(i, k)) = of_z(1 + i)
          end do
          column = 0
          call add_few_columns(square, known, column)
          call sum_equations(old, column, known, x)
          x = -x
        end if
        if (kept%n > 0) call solve_lu(kept%n, workspace%factors, workspace%pivots, workspace%work)
        call fill_independent(old, x, column)
        column = column + known
        do i = 1, exchange%n_images
          exchange%images(i, exchange%n_columns) = row_of_product(square, contacts%n_motions, exchange%image_rows(i), column)
        end do
      end associate
      kept%n_operations = kept%n_operations + 2 * real(kept%n, rk)**2 + 2 * real(n, rk) * exchange%n_images
    end associate
  end subroutine find_column

  !> Computes y of all columns in the rows that a law needs, if they are not there yet.
  subroutine find_images(square, contacts, law, workspace)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_unknown_t), intent(in) :: law
    type(friction_workspace_t), intent(inout) :: workspace
    integer :: a, j

    associate (kept => workspace%kept, exchange => workspace%kept%exchange, n => size(square, 1))
      do a = 1, law%n_rows
        if (abs(law%of_y(a)) <= 0) cycle
        if (exchange%image_of(law%rows(a)) > 0) cycle
        exchange%n_images = exchange%n_images + 1
        exchange%image_of(law%rows(a)) = exchange%n_images
        exchange%image_rows(exchange%n_images) = law%rows(a)
        do j = 1, exchange%n_columns
          exchange%images(exchange%n_images, j) = row_of_product(square, contacts%n_motions, law%rows(a), exchange%columns(:n, j))
        end do
        kept%n_operations = kept%n_operations + 2 * real(n, rk) * exchange%n_columns
      end do
    end associate
  end subroutine find_images

  !> Returns one row of W z or A z, by its column: both are symmetric, but for the signs where rows of motions meet others.
  real(rk) function row_of_product(square, n_motions, row, z) result(y)
    real(rk), contiguous, intent(in) :: square(:, :)
    integer, intent(in) :: n_motions
    !> not one of a motion
    integer, intent(in) :: row
    real(rk), contiguous, intent(in) :: z(:)
    real(rk) :: products(1)
    integer :: i

    call multiply_transpose(1.0_rk, square(:, row:row), z, 0.0_rk, products)
    y = products(1)
    do i = size(z) - n_motions + 1, size(z)
      y = y - 2 * square(i, row) * z(i)
    end do
  end function row_of_product

  !> Computes J^-1 b, or where other laws than those of C differ what comes near it. Requires: prepare_exchange.
  subroutine divide(square, contacts, unknowns, workspace, b)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    !> of J
    type(friction_unknown_t), intent(in) :: unknowns(:)
    type(friction_workspace_t), intent(inout) :: workspace
    !> in: right-hand side of each equation; out: unknowns; shape (n)
    real(rk), contiguous, intent(inout) :: b(:)
    integer :: i, j

    associate (kept => workspace%kept, exchange => workspace%kept%exchange, n => size(square, 1), x => workspace%work)
      do i = 1, exchange%n
        j = exchange%place_in_new(exchange%laws(i)%home)
        exchange%x(i) = 0
        if (j > 0) exchange%x(i) = b(j)
      end do
      do i = 1, kept%n
        x(i) = 0
        j = exchange%place_in_new(kept%unknowns(i)%home)
        if (j > 0) x(i) = b(j)
      end do
      if (kept%n > 0) call solve_lu(kept%n, workspace%factors, workspace%pivots, x)
      call fill_independent(kept%unknowns(:kept%n), x(:kept%n), exchange%known(:n))
      if (exchange%n > 0) call correct(square, contacts, workspace)
      call start_unknowns(unknowns, exchange%known(:n), b)
      kept%n_operations = kept%n_operations + 2 * real(kept%n, rk)**2
    end associate
  end subroutine divide

  !> Changes z, which is exchange%known, so that it meets the laws of C.
  subroutine correct(square, contacts, workspace)
    real(rk), contiguous, intent(in) :: square(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    integer :: a, i

    associate (kept => workspace%kept, exchange => workspace%kept%exchange, n => size(square, 1))
      associate (z => exchange%known(:n))
        do i = 1, exchange%n
          associate (law => exchange%laws(i))
            do a = 1, law%n_rows
              if (abs(law%of_y(a)) > 0) exchange%x(i) = exchange%x(i) - law%of_y(a) * &
                row_of_product(square, contacts%n_motions, law%rows(a), z)
              exchange%x(i) = exchange%x(i) - law%of_z(a) * z(law%rows(a))
            end do
          end associate
        end do
        call solve_lu(exchange%n, exchange%square, exchange%pivots, exchange%x)
      end associate
      ! in the order of rows, as that of columns depends on what was solved before
      do i = 1, exchange%n
        associate (j => exchange%column_of(exchange%laws(i)%home))
          call add_few_columns(exchange%columns(:, j:j), exchange%x(i:i), exchange%known)
        end associate
      end do
      kept%n_operations = kept%n_operations + 4 * real(n, rk) * exchange%n + 2 * real(exchange%n, rk)**2
    end associate
  end subroutine correct
end module sig_friction_exchange
