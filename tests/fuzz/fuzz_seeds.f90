! SPDX-License-Identifier: BSD-3-Clause
!> Small files of the program's own formats: what the mutations begin with.
module fuzz_seeds
  use sig_errors, only: error_report, error_t
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_model_file, only: write_model
  use sig_snapshot_shard, only: shard_content_t, shard_writer_t, snapshot_record_t
  use sig_snapshot_store, only: records_of_set, snapshot_set_t, write_snapshots
  use sig_text, only: string_t
  use tiny_model, only: add_fields, add_full_order, build_interpolated_model, build_tiny_model
  implicit none(type, external)
  private
  public :: write_seeds, provenance, n_parameters, n_dofs, n_multipliers

  character(16), parameter :: provenance = '0123456789abcdef'
  !> sizes of a record of the shard
  integer, parameter :: n_parameters = 2, n_dofs = 3, n_multipliers = 1

contains

  !> Writes all seeds into a folder that is there.
  subroutine write_seeds(folder, sentence)
    character(*), intent(in) :: folder
    !> empty where all went well
    character(:), allocatable, intent(out) :: sentence
    type(error_t), allocatable :: error
    type(model_t) :: model

    sentence = ''
    call write_shard(folder // '/seed.shard', error)
    if (.not. allocated(error)) call write_set(folder // '/snapshots.h5', error)
    call build_tiny_model(model)
    if (.not. allocated(error)) call write_model(folder // '/model.h5', model, error)
    call add_fields(model)
    if (.not. allocated(error)) call write_model(folder // '/model_fields.h5', model, error)
    call build_tiny_model(model)
    call add_full_order(model)
    if (.not. allocated(error)) call write_model(folder // '/model_full_order.h5', model, error)
    call build_interpolated_model(model)
    if (.not. allocated(error)) call write_model(folder // '/model_interpolated.h5', model, error)
    if (allocated(error)) sentence = error_report(error)
  end subroutine write_seeds

  pure function record_at(mu) result(record)
    real(rk), intent(in) :: mu
    type(snapshot_record_t) :: record

    record%parameters = [mu, 1 - mu]
    record%displacement = [mu, 2 * mu, 3 * mu]
    record%multipliers = [10 * mu]
    record%n_iterations = 3
    record%reason = 1
  end function record_at

  subroutine write_shard(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(shard_writer_t) :: writer
    type(snapshot_record_t) :: record
    integer :: i

    call writer%create(path, shard_content_t(provenance, n_parameters, n_dofs, n_multipliers), error)
    do i = 1, 5
      if (allocated(error)) return
      record = record_at(0.1_rk * i)
      call writer%append([record], error)
    end do
    if (.not. allocated(error)) call writer%close(error)
  end subroutine write_shard

  subroutine write_set(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(snapshot_set_t) :: set
    integer :: i

    set%provenance = provenance
    allocate (set%parameter_names(n_parameters), set%term_texts(2))
    set%parameter_names(1)%text = 'a'
    set%parameter_names(2)%text = 'b'
    set%term_texts(1)%text = '1'
    set%term_texts(2)%text = '-a'
    set%parameters = reshape([(0.1_rk * i, 1 - 0.1_rk * i, i=1, 4)], [n_parameters, 4])
    set%displacement = reshape([(0.1_rk * i, i=1, 4 * n_dofs)], [n_dofs, 4])
    set%multipliers = reshape([(1.0_rk * i, i=1, 4 * n_multipliers)], [n_multipliers, 4])
    set%residuals = reshape([(1.0e-12_rk * i, i=1, 20)], [5, 4])
    set%n_iterations = [1, 2, 3, 4]
    set%reasons = [1, 1, -4, 1]
    set%seconds = [0.1_rk, 0.2_rk, 0.3_rk, 0.4_rk]
    set%free_response = reshape([(1.0_rk * i, i=1, 2 * n_dofs)], [n_dofs, 2])
    call write_snapshots(path, set, records_of_set(set), 'm', 'N', [string_t('m'), string_t('m')], error)
  end subroutine write_set
end module fuzz_seeds
